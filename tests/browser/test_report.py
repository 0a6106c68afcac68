"""The gallery of the report in a real browser: no errors, no network, zoom and read-out, phone, dark, paper.

    pytest tests/browser

Needs Chromium (skipped without it) and cargo, or the gallery already written: HYDROSYSID_GALLERY=gallery.html.
"""

import base64
import os
import re
import subprocess
from pathlib import Path

import pytest
from chromium import Page

CURVES = "document.querySelector('#figure-1 .wide svg')"
LABELS = f"[...{CURVES}.querySelectorAll('.lx text')].map(t => t.textContent).join(' ')"
PATH = f"{CURVES}.querySelector('[data-k=\"1\"]').getAttribute('d')"


@pytest.fixture(scope="session")
def gallery(tmp_path_factory, built) -> Path:
    if written := os.environ.get("HYDROSYSID_GALLERY"):
        return Path(written)
    file = tmp_path_factory.mktemp("report") / "gallery.html"
    subprocess.run([built("example", "report_gallery"), str(file)], check=True, stdout=subprocess.DEVNULL)
    return file


@pytest.fixture(scope="session")
def report(tmp_path_factory, built) -> Path:
    """The demo's report: figures of results instead of one of each kind."""
    if written := os.environ.get("HYDROSYSID_REPORT"):
        return Path(written)
    folder = tmp_path_factory.mktemp("demo") / "demo"
    subprocess.run([built("bin", "hydrosysid"), "demo", "--quiet", "--folder", str(folder)], check=True)
    return folder / "report.html"


def middle(page: Page) -> tuple[float, float]:
    """Scrolls to the first figure and gives the middle of its first panel."""
    page.run(f"{CURVES}.scrollIntoView({{block: 'center'}})")
    box = page.run(f"(() => {{ const b = {CURVES}.querySelector('.frame').getBoundingClientRect();"
                   "return [b.left + b.width / 2, b.top + b.height / 2, b.width]; })()")
    return box[0], box[1]


def test_it_loads_without_errors_and_without_network(browser, gallery):
    browser.open(gallery)
    assert browser.errors == []
    assert [url for url in browser.urls if not url.startswith(("file:", "data:"))] == []
    assert gallery.stat().st_size < 2_000_000
    assert browser.run("document.querySelectorAll('.chart-figure').length") == 6
    assert browser.run("[...document.querySelectorAll('.wide svg')].every(s => s.getBoundingClientRect().height > 100)")
    assert browser.run("new Set([...document.querySelectorAll('[id]')].map(e => e.id)).size"
                       " === document.querySelectorAll('[id]').length")


def test_the_demos_report_is_sound_on_desk_and_phone_light_and_dark(browser, report):
    assert report.stat().st_size < 2_000_000
    for width, dark in ((1000, False), (1000, True), (390, False), (390, True)):
        browser.open(report, width=width, dark=dark)
        assert browser.errors == []
        assert browser.run("document.documentElement.scrollWidth") <= width
        assert browser.run("/NaN|undefined|Infinity|`/.test(document.querySelector('main').innerText)") is False
    titles = browser.run("[...document.querySelectorAll('.chart-figure .title')].map(e => e.textContent)")
    for title in ("What the data can separate", "The same parameter from other sources", "Drag in surge",
                  "Each run's own model on every run, yaw", "Residuals against u", "The gap in yaw"):
        assert title in titles
    paper = base64.b64decode(browser.call("Page.printToPDF", printBackground=True)["data"])
    assert paper.startswith(b"%PDF-")


def test_the_first_screen_answers(browser, report):
    browser.open(report, width=1400, height=1000)
    top = "e => e.getBoundingClientRect().top"
    begin = browser.run(f"['.verdict', '.first .chart-figure', '.first .table'].map(s => document.querySelector(s)).map({top})")
    assert all(y < 1000 for y in begin), begin
    titles = browser.run("[...document.querySelectorAll('.first .title')].map(e => e.textContent)")
    assert titles[0].startswith("The gap in ") and titles[1].startswith("The worst run: "), titles
    assert titles[2:] == ["Random force", "Parameters", "Noise of the sensors"]
    legend = browser.run("[...document.querySelectorAll('.first .chart-figure')][1].querySelector('.wide').textContent")
    assert "measured" in legend and "without what was missing" in legend
    links = browser.run("[...document.querySelectorAll('nav a')].map(a => [a.textContent, a.getAttribute('href')])")
    heads = browser.run("[...document.querySelectorAll('section')].map(s => [s.querySelector('h2').textContent, '#' + s.id])")
    assert links == heads and links[0][0] == "What is missing"


def test_long_tables_are_folded_and_filtered(browser, report):
    browser.open(report)
    folded = "[...document.querySelectorAll('figure.table details')]"
    assert browser.run(f"{folded}.length") > 0
    assert browser.run(f"{folded}.every(d => !d.open && d.querySelectorAll('tbody tr').length > 15)")
    assert browser.run("[...document.querySelectorAll('figure.table')].every(t => t.querySelector('details')"
                       "|| t.querySelectorAll('tbody tr').length <= 15)")
    table = f"{folded}.find(d => /run06/.test(d.textContent))"
    browser.run(f"{table}.querySelector('summary').click()")
    browser.run(f"(() => {{ const f = {table}.querySelector('.filter'); f.value = 'run06 yaw';"
                "f.dispatchEvent(new Event('input')); })()")
    rows = browser.run(f"[...{table}.querySelectorAll('tbody tr')].filter(r => r.offsetParent).map(r => r.textContent)")
    assert rows and all("run06" in row and "yaw" in row for row in rows), rows


def test_the_rest_is_folded_and_every_run_stands_beside_the_others(browser, report):
    for width, dark in ((1400, False), (820, False), (390, False), (1400, True), (820, True), (390, True)):
        browser.open(report, width=width, dark=dark)
        assert browser.errors == []
        assert browser.run("document.documentElement.scrollWidth") <= width
        assert browser.run("[...document.querySelectorAll('section > details')].every(d => !d.open)")
    heads = browser.run("[...document.querySelectorAll('section')].filter(s => s.querySelector(':scope > details'))"
                        ".map(s => s.querySelector('h2').textContent)")
    assert heads == ["Measured and simulated", "Residual against each state", "Forces"], heads
    small = browser.run("[...document.querySelectorAll('.multiples')].map(m => m.querySelectorAll('.small svg').length)")
    assert small and max(small) >= 6, small
    # two of them beside each other on a phone
    tops = browser.run("[...document.querySelectorAll('.multiples .small')].slice(0, 2).map(e => e.getBoundingClientRect().top)")
    assert tops[0] == tops[1]
    section = "[...document.querySelectorAll('section > details')][0]"
    seen = f"{section}.querySelector('.chart-figure').checkVisibility()"
    assert browser.run(seen) is False
    browser.run(f"{section}.querySelector('summary').click()")
    assert browser.run(seen) is True


def test_the_first_screen_tells_intervals_and_does_not_contradict_itself(browser, report):
    browser.open(report)
    heads = browser.run("[...document.querySelectorAll('.first .table thead')][1].innerText")
    assert "95 % interval" in heads and "±" not in heads
    verdict = browser.run("document.querySelector('.verdict').textContent")
    assert verdict.startswith("Explained: the Munk moment") and "as well as it says" not in verdict
    assert verdict.count("random force") <= 1


def test_paper_holds_two_figures_a_page(browser, report):
    browser.open(report)
    # the figures with curves alone, one after the other
    count = browser.run("(() => { const figures = [...document.querySelectorAll('.chart-figure')].slice(0, 8);"
                        "document.querySelector('main').replaceChildren(...figures); return figures.length; })()")
    paper = base64.b64decode(browser.call("Page.printToPDF", printBackground=True, preferCSSPageSize=False,
                                          paperWidth=8.27, paperHeight=11.69)["data"])
    pages = len(re.findall(rb"/Type\s*/Page\b", paper))
    # two at least on each
    assert count == 8 and 2 <= pages <= 4, (count, pages)


def test_every_figure_with_curves_zooms_and_reads(browser, report):
    browser.open(report)
    browser.run("document.querySelectorAll('details').forEach(d => { d.open = true; })")
    figures = browser.run("[...document.querySelectorAll('.chart-figure')].filter(f => f.querySelector('.wide svg.zooms'))"
                          ".map(f => f.id)")
    assert len(figures) > 10
    for figure in figures:
        svg = f"document.querySelector('#{figure} .wide svg')"
        browser.run(f"{svg}.scrollIntoView({{block: 'center'}})")
        x, y = browser.run(f"(() => {{ const b = {svg}.querySelector('.frame').getBoundingClientRect();"
                           "return [b.left + b.width / 2, b.top + b.height / 2]; })()")
        browser.mouse("mouseMoved", x, y)
        assert browser.run("document.querySelectorAll('.cross').length") == 1, figure
        labels = f"[...{svg}.querySelectorAll('.lx text')].map(t => t.textContent).join(' ')"
        before = browser.run(labels)
        for _ in range(6):
            browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-120)
        assert browser.run(labels) != before, figure
        assert "NaN" not in browser.run(f"{svg}.innerHTML"), figure
        browser.run(f"document.querySelector('#{figure} .reset').click()")
        assert browser.run(labels) == before, figure
    assert browser.errors == []


def test_tables_copy_as_csv_and_latex(browser, report):
    browser.open(report)
    found = "[...document.querySelectorAll('figure.table')].find(f => /symbol/.test(f.innerText))"
    table = browser.run(f"{found}.id")
    texts = browser.run(f"[...document.querySelectorAll('#{table} .copy')].map(b => b.dataset.text)")
    assert len(texts) == 2
    csv, latex = texts
    assert csv.splitlines()[0].startswith("effect,common name,degree of freedom,symbol")
    assert len(csv.splitlines()) == 1 + browser.run(f"document.querySelectorAll('#{table} tbody tr').length")
    assert r"\begin{tabular}" in latex
    button = f"document.querySelector('#{table} .copy')"
    browser.run(f"{button}.click()")
    browser.run("new Promise(done => setTimeout(done, 200))")
    assert browser.run(f"{button}.textContent") == "Copied"


def test_no_number_is_broken(browser, gallery):
    browser.open(gallery)
    assert browser.run("/NaN|undefined|Infinity/.test(document.querySelector('main').innerHTML)") is False


def test_wheel_zooms_and_double_click_resets(browser, gallery):
    browser.open(gallery)
    x, y = middle(browser)
    labels, path = browser.run(LABELS), browser.run(PATH)
    for _ in range(4):
        browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-120)
    assert browser.run(LABELS) != labels
    assert browser.run(PATH) != path and "NaN" not in browser.run(PATH)
    assert browser.run("document.querySelector('#figure-1 .reset').hidden") is False
    for count in (1, 2):
        for kind in ("mousePressed", "mouseReleased"):
            browser.mouse(kind, x, y, button="left", clickCount=count)
    assert browser.run(LABELS) == labels
    assert browser.run(PATH) == path
    assert browser.errors == []


def test_dragging_zooms_to_the_stretch(browser, gallery):
    browser.open(gallery)
    x, y = middle(browser)
    browser.mouse("mousePressed", x - 60, y, button="left", clickCount=1)
    browser.mouse("mouseMoved", x + 60, y, button="left", buttons=1)
    assert browser.run(f"{CURVES}.querySelectorAll('.choice').length") == 1
    browser.mouse("mouseReleased", x + 60, y, button="left", clickCount=1)
    # 120 of some 700 px of 120 s.
    seconds = [float(label) for label in browser.run(LABELS).split()]
    assert 10 < seconds[-1] - seconds[0] < 25 and all(45 < s < 75 for s in seconds)


def test_hover_reads_values(browser, gallery):
    browser.open(gallery)
    x, y = middle(browser)
    browser.mouse("mouseMoved", x, y)
    text = browser.run("document.querySelector('.readout').innerText")
    assert text.startswith(("Time 60", "Time 59"))
    assert "measured" in text and "simulated" in text and "Measured − simulated" in text
    browser.mouse("mouseMoved", 1, 1)
    assert browser.run("document.querySelector('.readout')") is None


def test_the_keyboard_zooms_too(browser, gallery):
    browser.open(gallery)
    labels = browser.run(LABELS)
    browser.run(f"{CURVES}.focus()")
    for key in ("+", "+", "ArrowRight"):
        browser.call("Input.dispatchKeyEvent", type="keyDown", key=key)
    assert browser.run(LABELS) != labels
    browser.call("Input.dispatchKeyEvent", type="keyDown", key="Escape")
    assert browser.run(LABELS) == labels


@pytest.mark.parametrize("width", [320, 360, 768, 1400])
def test_nothing_is_wider_than_the_screen(browser, gallery, width):
    browser.open(gallery, width=width)
    assert browser.run("document.documentElement.scrollWidth") <= width
    size = browser.run("(() => { const s = [...document.querySelectorAll('svg.chart')].find(s => s.clientWidth);"
                       "return 11.5 * s.getBoundingClientRect().width / s.viewBox.baseVal.width; })()")
    assert size > 9, "text in figures must stay readable"


@pytest.mark.parametrize("dark", [False, True])
def test_labels_stay_inside_the_figures(browser, gallery, dark):
    for width in (360, 1000):
        browser.open(gallery, width=width, dark=dark)
        outside = browser.run(
            "[...document.querySelectorAll('svg.chart')].filter(s => s.clientWidth).flatMap(s => {"
            "const f = s.getBoundingClientRect(); return [...s.querySelectorAll('text')].filter(t => {"
            "const b = t.getBoundingClientRect(); return b.width && (b.left < f.left - 1 || b.right > f.right + 1"
            "|| b.top < f.top - 1 || b.bottom > f.bottom + 1); }).map(t => t.textContent); })")
        assert outside == []


def test_dark_is_dark(browser, gallery):
    browser.open(gallery, dark=True)
    assert browser.run("getComputedStyle(document.body).backgroundColor") == "rgb(21, 25, 29)"


def test_it_is_whole_without_its_script(browser, gallery):
    browser.open(gallery, script=False)
    root = browser.call("DOM.getDocument", depth=0)["root"]["nodeId"]
    lines = browser.call("DOM.querySelectorAll", nodeId=root, selector=".wide .line")["nodeIds"]
    assert len(lines) >= 3


def test_it_prints(browser, gallery):
    browser.open(gallery)
    paper = base64.b64decode(browser.call("Page.printToPDF", printBackground=True)["data"])
    assert paper.startswith(b"%PDF-") and len(paper) > 20_000


def test_a_figure_on_its_own_is_a_sound_file(browser, gallery):
    browser.open(gallery.with_suffix(".svg"))
    assert browser.run("document.documentElement.nodeName") == "svg"
    assert browser.run("document.querySelector('parsererror')") is None
    assert browser.run("getComputedStyle(document.querySelector('.line.t1')).stroke") == "rgb(10, 103, 173)"
