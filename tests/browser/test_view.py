"""The page to work with in a real browser: from dropped logs to a saved report, by mouse and by keyboard alone.

    pytest tests/browser

Needs Chromium (skipped without it) and the command: HYDROSYSID_COMMAND, or cargo to build it. The logs are those of a
vehicle in a pool (`realdata/bolt` of HYDROSYSID_SHARED, else of `shared` beside the repository).
"""

import os
import re
import shutil
import subprocess
import time
from pathlib import Path

import pytest
from chromium import Page

ROOT = Path(__file__).resolve().parents[2]
LOGS = ["yaw_test.csv", "yaw_test_2.csv", "yaw_test_3.csv", "yaw_test_4.csv"]


@pytest.fixture(scope="session")
def command(built) -> str:
    return os.environ.get("HYDROSYSID_COMMAND") or str(built("bin", "hydrosysid"))


@pytest.fixture(scope="session")
def bolt() -> Path:
    folder = Path(os.environ.get("HYDROSYSID_SHARED", ROOT.parent / "shared")) / "realdata" / "bolt"
    if not folder.exists():
        assert os.environ.get("CI") != "true", f"no reference data at {folder}"
        pytest.skip(f"no reference data at {folder}")
    return folder


@pytest.fixture
def vehicle(tmp_path, bolt) -> Path:
    """A folder with what is known of the vehicle, and no run yet."""
    text = (bolt / "campaign.toml").read_text().split("[[run]]")[0]
    text = text.replace('dofs = ["heave", "yaw"]', 'dofs = ["yaw"] # the pool is shallow').replace(', "bias@heave"', "")
    (tmp_path / "campaign.toml").write_text("# Bolt, as it was weighed\n" + text)
    shutil.copy(bolt / "t200_16v.csv", tmp_path)
    return tmp_path


@pytest.fixture
def serve(command):
    """Serves a folder and gives the address; all servers end with the test."""
    servers = []

    def start(folder: Path) -> str:
        server = subprocess.Popen([command, "view", str(folder), "--no-browser"], stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True)
        servers.append(server)
        address = server.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[0-9a-f]{64}", address), address
        return address

    yield start
    for server in servers:
        server.terminate()
        server.wait(timeout=20)


def drop(page: Page, files: list[Path]) -> None:
    """Drops files on the page, as from a folder's window."""
    x, y = page.run("(() => { const b = document.querySelector('#drop').getBoundingClientRect();"
                    "return [b.left + b.width / 2, b.top + b.height / 2]; })()")
    data = {"items": [], "files": [str(file) for file in files], "dragOperationsMask": 1}
    for kind in ("dragEnter", "dragOver", "drop"):
        page.call("Input.dispatchDragEvent", type=kind, x=x, y=y, data=data)


def text(page: Page, selector: str) -> str:
    return page.run(f"document.querySelector({selector!r})?.innerText ?? ''")


FITTED = "!!view.campaign && !!fit.told && fit.told.stamp === view.campaign.stamp && document.querySelector('#fit-work').hidden"
# Fitted or refused: either is a verdict, and nothing is at work.
ANSWERED = "!!view.campaign && !!document.querySelector('#fit-said .verdict') && document.querySelector('#fit-work').hidden"
LIGHTS = "document.querySelectorAll('#log-list .topic').length > 0"


def no_complaint(page: Page) -> None:
    assert page.run("document.querySelector('#message').hidden"), text(page, "#message")
    assert page.errors == []


def test_from_dropped_logs_to_the_saved_report(browser, serve, vehicle, bolt):
    address = serve(vehicle)
    browser.open(address, width=1400, height=1000)
    # a campaign without a run is none yet, and says so
    browser.until("!!view.campaign")
    assert "no run" in text(browser, "#message")
    drop(browser, [bolt / name for name in LOGS])
    browser.until(f"document.querySelectorAll('#log-list tbody tr').length === {len(LOGS)} && {LIGHTS}")
    browser.until(FITTED)
    no_complaint(browser)
    file = vehicle / "campaign.toml"
    assert file.read_text().startswith("# Bolt, as it was weighed") and "# the pool is shallow" in file.read_text()
    for name in LOGS:
        assert (vehicle / name).read_bytes() == (bolt / name).read_bytes()

    # the columns of the log, each with a light, and a mapping that is live
    assert browser.run("document.querySelectorAll('#column-list tbody tr').length") == 13
    assert text(browser, "#column-list").count("✓") >= 10
    browser.run("(() => { const s = document.querySelector('#column-0-4-is'); s.value = 'phi';"
                "s.dispatchEvent(new Event('change')); })()")
    browser.until("document.querySelector('#column-0-4-is').value === 'phi' && document.querySelectorAll('#log-list .light.red').length > 0")
    assert "[log.columns]" in file.read_text()
    browser.run("document.querySelector('#undo').click()")
    browser.until(f"document.querySelectorAll('#log-list .light.red').length === 0 && {LIGHTS}")

    # brushing the plot sets the stretch
    browser.until("!!document.querySelector('#plot .wide .frame')")
    browser.run("document.querySelector('#plot').scrollIntoView({block: 'center'})")
    left, width, y = browser.run("(() => { const b = document.querySelector('#plot .wide .frame').getBoundingClientRect();"
                                 "return [b.left, b.width, b.top + b.height / 2]; })()")
    browser.mouse("mousePressed", left + 0.1 * width, y, button="left", clickCount=1)
    browser.mouse("mouseMoved", left + 0.8 * width, y, button="left", buttons=1)
    browser.mouse("mouseReleased", left + 0.8 * width, y, button="left", clickCount=1)
    browser.until("Number(document.querySelector('#stretch-0-to')?.value) > 20")
    browser.until(FITTED)
    written = re.search(r"from = ([\d.]+)\nto = ([\d.]+)", file.read_text())
    assert 1 < float(written[1]) < 5 and 20 < float(written[2]) < 26
    # the last log judges
    browser.run("document.querySelector('#log-3').click()")
    browser.until("document.querySelector('#stretches-of').textContent.includes('yaw_test_4') && !!document.querySelector('#stretch-0-role')")
    browser.run("(() => { const s = document.querySelector('#stretch-0-role'); s.value = 'validate';"
                "s.dispatchEvent(new Event('change')); })()")
    browser.until("view.campaign.logs[3].stretches[0].role === 'validate'")
    browser.until(FITTED)

    # an effect switched on is in the file, and fit and overlay follow within a second
    overlay = "document.querySelector('#overlay .wide')?.innerHTML ?? ''"
    before = browser.run(overlay)
    results = browser.run("fit.results")
    browser.run("document.querySelector('#effect-bias\\\\@yaw').click()")
    followed = browser.until(f"fit.results !== {results} && ({overlay}) !== {before!r}", 20)
    assert followed < float(os.environ.get("HYDROSYSID_FOLLOWS", "5")), "a build for tests, on busy cores"
    browser.until(FITTED)
    assert '"bias@yaw"' in file.read_text()
    assert "a constant force" in text(browser, "#parameters")
    browser.run("document.querySelector('#effect-bias\\\\@yaw').click()")
    browser.until("!document.querySelector('#effect-bias\\\\@yaw').checked && !view.campaign.text.includes('bias@yaw')")
    browser.until(FITTED)

    # the search, with its progress, which is noted as it comes: a short search is over before anybody asks
    browser.run("(() => { const box = document.querySelector('#discovery-work'); window.progressSeen = false;"
                "new MutationObserver(() => { window.progressSeen ||= !box.hidden; }).observe(box, {attributes: true}); })()")
    browser.run("document.querySelector('#discover').click()")
    browser.until("window.progressSeen")
    browser.until("document.querySelector('#discovery-work').hidden && !!document.querySelector('#discovery-said .verdict')", 300)
    no_complaint(browser)

    browser.run("document.querySelector('#report-save').click()")
    browser.until("!!document.querySelector('#report-open')", 300)
    report = (vehicle / "report.html").read_text()
    assert report.startswith("<!doctype html>") and "bolt: identification" in report
    no_complaint(browser)
    elsewhere = [url for url in browser.urls if not url.startswith((address.split("?")[0], "data:", "blob:"))]
    assert elsewhere == []


def tab_to(page: Page, element: str, shift: bool = False) -> None:
    """Goes to an element by the tabulator alone; what has the focus shows it."""
    for _ in range(400):
        if page.run("document.activeElement.id") == element:
            return
        page.press("Tab", shift)
    raise AssertionError(f"the keyboard does not reach {element}")


def test_with_the_keyboard_alone(browser, serve, vehicle, bolt):
    browser.open(serve(vehicle), width=1200, height=900)
    browser.until("!!view.campaign")
    browser.call("Page.setInterceptFileChooserDialog", enabled=True)
    tab_to(browser, "files")
    browser.press("Enter")
    chooser = browser.wait_for("Page.fileChooserOpened")
    browser.call("DOM.setFileInputFiles", files=[str(bolt / name) for name in LOGS], backendNodeId=chooser["backendNodeId"])
    browser.call("Page.setInterceptFileChooserDialog", enabled=False)
    browser.until(f"document.querySelectorAll('#log-list tbody tr').length === {len(LOGS)} && {LIGHTS}")
    browser.until(FITTED)

    tab_to(browser, "log-2")
    browser.press("Enter")
    browser.until("document.querySelector('#stretches-of').textContent.includes('yaw_test_3') && !!document.querySelector('#stretch-0-role')")
    assert browser.run("document.activeElement.id") == "log-2", "what is drawn anew keeps the focus"
    tab_to(browser, "stretch-0-role")
    browser.press("ArrowDown")
    browser.until("view.campaign.logs[2].stretches[0].role === 'validate'")
    tab_to(browser, "stretch-0-from")
    for key in "2.5":
        browser.press(key)
    browser.press("Tab")
    browser.until("view.campaign.logs[2].stretches[0].from === 2.5")
    browser.until(FITTED)
    assert "from = 2.5" in (vehicle / "campaign.toml").read_text()

    # a column is mapped: what the keys pass on the way is not saved
    tab_to(browser, "log-0")
    browser.press("Enter")
    browser.until("document.querySelector('#stretches-of').textContent.includes('yaw_test.csv')")
    tab_to(browser, "column-0-4-is")
    for key in "phi":
        browser.press(key)
    browser.until("view.campaign.text.includes('[log.columns]') && document.querySelectorAll('#log-list .light.red').length > 0")
    assert browser.run("document.activeElement.id") == "column-0-4-is"
    assert "phi" in (vehicle / "campaign.toml").read_text().split("[log.columns]")[1].split("[[")[0]
    no_complaint(browser)
    tab_to(browser, "undo", shift=True)
    browser.press("Enter")
    browser.until(f"!view.campaign.text.includes('[log.columns]') && {LIGHTS}")
    browser.until(FITTED)

    tab_to(browser, "find-effect")
    for key in "constant force":
        browser.press(key)
    tab_to(browser, "effect-bias@yaw")
    browser.press(" ")
    browser.until("view.campaign.text.includes('bias@yaw')")
    assert browser.run("document.activeElement.id") == "effect-bias@yaw"
    browser.until(FITTED)
    browser.press(" ")
    browser.until("!view.campaign.text.includes('bias@yaw')")
    browser.until(FITTED)

    tab_to(browser, "discover")
    browser.press("Enter")
    browser.until("document.querySelector('#discovery-work').hidden && !!document.querySelector('#discovery-said .verdict')", 300)
    tab_to(browser, "report-name")
    browser.press("Tab")
    tab_to(browser, "report-save")
    browser.press("Enter")
    browser.until("!!document.querySelector('#report-open')", 300)
    assert (vehicle / "report.html").exists()
    no_complaint(browser)


def test_an_effect_is_adopted_with_the_keyboard(browser, command, serve, tmp_path):
    """The campaign of the demo lacks the Munk moment: the search names it, and a key adopts it."""
    folder = tmp_path / "demo"
    subprocess.run([command, "demo", "--folder", str(folder), "--quiet"], check=True)
    file = folder / "hidden" / "campaign.toml"
    assert "coriolis_yaw" not in file.read_text()
    browser.open(serve(file.parent), width=1000)
    browser.until(FITTED, 120)
    tab_to(browser, "discover")
    browser.press("Enter")
    browser.until("document.querySelector('#discovery-work').hidden && !!document.querySelector('#discovery-said .verdict')", 300)
    assert "the Munk moment" in text(browser, "#discovery-said")
    tab_to(browser, "adopt-coriolis_yaw")
    browser.press("Enter")
    browser.until("view.campaign.text.includes('\"coriolis_yaw\"')")
    assert '"coriolis_yaw"' in file.read_text()
    # it is tied to the masses, so that it has no parameter of its own to show; behind the first look comes the fit
    assert browser.run("document.getElementById('effect-coriolis_yaw').checked")
    browser.until("document.querySelector('#fit-said').innerText.includes('8 s ahead err as much as expected')", 120)
    no_complaint(browser)


def test_the_first_logs_make_the_campaign(browser, serve, tmp_path, bolt):
    browser.open(serve(tmp_path), width=1000)
    browser.until("!!view.campaign && !document.querySelector('#new').hidden")
    browser.run("document.querySelector('#known-vehicle').value = 'bluerov2-heavy'")
    drop(browser, [bolt / name for name in LOGS[:3]])
    browser.until("document.querySelectorAll('#log-list tbody tr').length === 3")
    # the thrusters of another vehicle: what these logs say of it depends on the estimator, but never on who asks when
    browser.until(ANSWERED)
    assert browser.run("!!fit.told !== !!document.querySelector('#fit-said .refused')")
    written = (tmp_path / "campaign.toml").read_text()
    assert "# guessed:" in written and written.count("[[run]]") >= 3
    # another log of the same name is no reason to lose the first
    other = tmp_path / "elsewhere"
    other.mkdir()
    (other / LOGS[0]).write_text("t,u\n0,1\n1,2\n")
    drop(browser, [other / LOGS[0]])
    browser.until("!document.querySelector('#message').hidden")
    assert "already exists and is a different log" in text(browser, "#message")
    assert (tmp_path / LOGS[0]).read_bytes() == (bolt / LOGS[0]).read_bytes()


@pytest.mark.parametrize("dark", [False, True])
def test_nothing_is_wider_than_the_screen(browser, serve, vehicle, bolt, dark):
    address = serve(vehicle)
    browser.open(address, width=1400, dark=dark)
    browser.until("!!view.campaign")
    drop(browser, [bolt / name for name in LOGS])
    browser.until(FITTED)
    for width in (1400, 820, 390):
        browser.open(address, width=width, height=900, dark=dark)
        browser.until(FITTED)
        browser.until("!!document.querySelector('#overlay svg') && !!document.querySelector('#plot svg')")
        assert browser.run("document.documentElement.scrollWidth") <= width
        assert browser.run("/NaN|undefined|null|\\[object/.test(document.querySelector('main').innerText)") is False
        unnamed = browser.run("[...document.querySelectorAll('main input, main select, main button')].filter(e => e.offsetParent"
                              " && !(e.labels?.length || e.getAttribute('aria-label') || e.innerText.trim())).map(e => e.id)")
        assert unnamed == []
    assert browser.errors == []


def test_an_edit_of_the_file_shows_and_an_ended_server_is_told(browser, command, vehicle, bolt):
    for name in LOGS[:2]:
        shutil.copy(bolt / name, vehicle)
    file = vehicle / "campaign.toml"
    file.write_text(file.read_text() + "".join(f'[[run]]\nfile = "{name}"\n' for name in LOGS[:2]))
    server = subprocess.Popen([command, "view", str(vehicle), "--no-browser"], stdout=subprocess.PIPE, text=True,
                              stderr=subprocess.DEVNULL)
    try:
        browser.open(server.stdout.readline().strip())
        browser.until(FITTED)
        file.write_text(file.read_text().replace('name = "bolt"', 'name = "Bolt II"'))
        browser.until("document.querySelector('#vehicle').textContent === 'Bolt II'")
    finally:
        server.terminate()
        server.wait(timeout=20)
    time.sleep(0.1)
    browser.until("document.querySelector('#message').innerText.includes('does not answer')")
