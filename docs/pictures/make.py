"""Draws the pictures of the book: terminal, report, page and notebook, each as a user sees it. `make pictures` calls it.

    python docs/pictures/make.py COMMAND [FOLDER]

COMMAND is the built `hydrosysid`; FOLDER takes the pictures (this folder when absent). Chromium draws, as in
`tests/browser`; the notebook needs the Python package.
"""

import ast
import base64
import html
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "tests" / "browser"))

from chromium import Page, find  # noqa: E402

# What a terminal shows of the codes that the command writes.
COLOURS = {"31": "#f47067", "32": "#57ab5a", "33": "#c69026", "34": "#539bf5"}
TERMINAL = """<!doctype html><meta charset="utf-8"><style>
body{margin:0;background:#22272e;color:#d5dce3;width:max-content}
pre{margin:0;padding:14px 18px;font:14px/1.35 "DejaVu Sans Mono",Menlo,Consolas,monospace}
.typed{color:#8ddb8c}
</style><pre>%s</pre>"""
NOTEBOOK = """<!doctype html><meta charset="utf-8"><style>
body{margin:0;background:#fff;color:#222;font:14px/1.5 system-ui,sans-serif;padding:16px 22px}
.in{background:#f6f8fa;border:1px solid #dde2e8;border-left:3px solid #4c78a8;padding:8px 12px;margin:12px 0 6px;
font:13px/1.45 "DejaVu Sans Mono",monospace;white-space:pre-wrap}
.out{margin:4px 0 10px 14px}
img{max-width:100%%}
</style>%s"""


def coloured(text: str) -> str:
    """Text with the colours of a terminal as HTML."""
    parts, opened = [], False
    for piece in re.split(r"(\x1b\[[0-9;]*m)", text):
        code = re.fullmatch(r"\x1b\[([0-9;]*)m", piece)
        if code is None:
            parts.append(html.escape(piece))
            continue
        if opened:
            parts.append("</span>")
        codes = code[1].split(";")
        colour = next((COLOURS[c] for c in codes if c in COLOURS), None)
        opened = codes not in ([""], ["0"])
        if opened:
            weight = "bold" if "1" in codes else "normal"
            parts.append(f'<span style="color:{colour or "inherit"};font-weight:{weight}">')
    return "".join(parts) + ("</span>" if opened else "")


def session(command: str, folder: Path, columns: int, calls: list[list[str]]) -> str:
    """What a terminal of so many columns shows after these calls."""
    environment = {**os.environ, "COLUMNS": str(columns), "CLICOLOR_FORCE": "1"}
    environment.pop("NO_COLOR", None)
    shown = []
    for words in calls:
        done = subprocess.run([command, *words], cwd=folder, env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=True)
        shown.append(f'<span class="typed">$ hydrosysid {html.escape(" ".join(words))}</span>\n{coloured(done.stdout)}')
    return "\n".join(shown)


def shot(page: Page, file: Path, width: int, height: int | None = None, scale: float = 1) -> None:
    """Saves what is open, from the top: `height` pixels of it, else all."""
    full = page.run("Math.ceil(document.documentElement.getBoundingClientRect().height)")
    clip = {"x": 0, "y": 0, "width": width, "height": height or full, "scale": scale}
    data = page.call("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)["data"]
    file.write_bytes(base64.b64decode(data))


def terminal(page: Page, text: str, scratch: Path, file: Path) -> None:
    scratch.write_text(TERMINAL % text, encoding="utf-8")
    page.open(scratch, width=1400, height=200)
    shot(page, file, page.run("Math.ceil(document.body.getBoundingClientRect().width)"))


def cells(notebook: Path, most: int) -> str:
    """The first code cells of a notebook with what they show, as HTML."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    names: dict = {"__name__": "__main__"}
    shown: list[str] = []
    code = [c for c in json.loads(notebook.read_text(encoding="utf-8"))["cells"] if c["cell_type"] == "code"]
    for cell in code[:most]:
        source = "".join(cell["source"])
        tree = ast.parse(source)
        last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, str(notebook), "exec"), names)
        value = eval(compile(ast.Expression(last.value), str(notebook), "eval"), names) if last else None
        shown.append(f'<div class="in">{html.escape(source)}</div>')
        if hasattr(value, "_repr_html_"):
            shown.append(f'<div class="out">{value._repr_html_()}</div>')
        elif plt.get_fignums():
            drawn = io.BytesIO()
            plt.savefig(drawn, dpi=70, bbox_inches="tight")
            picture = base64.b64encode(drawn.getvalue()).decode()
            shown.append(f'<div class="out"><img src="data:image/png;base64,{picture}"></div>')
        elif value is not None:
            shown.append(f'<div class="out"><pre>{html.escape(repr(value))}</pre></div>')
        plt.close("all")
    return NOTEBOOK % "".join(shown)


def main() -> None:
    command = str(Path(sys.argv[1]).resolve())
    out = Path(sys.argv[2]).resolve() if len(sys.argv) > 2 else HERE
    program = find()
    if program is None:
        sys.exit("no Chromium on the path: the pictures cannot be drawn")
    page = Page(program)
    with tempfile.TemporaryDirectory() as scratch_folder:
        folder = Path(scratch_folder)
        subprocess.run([command, "demo", "--quiet", "--folder", "demo"], cwd=folder, check=True)
        shutil.copyfile(folder / "demo" / "gap.svg", out / "gap.svg")
        scratch = folder / "picture.html"
        for columns in (80, 120):
            for name, calls in (
                ("check-fit", [["check", "demo/hidden"], ["fit", "demo/hidden"]]),
                ("discover", [["discover", "demo/hidden"]]),
            ):
                text = session(command, folder, columns, calls)
                terminal(page, text, scratch, out / f"terminal-{name}-{columns}.png")
        report = folder / "demo" / "report.html"
        page.open(report, width=1400, height=1000)
        shot(page, out / "report.png", 1400, 1300, scale=0.6)
        page.open(report, width=390, height=844, dark=True)
        shot(page, out / "report-phone-dark.png", 390, 1100)
        server = subprocess.Popen([command, "view", "demo/hidden", "--no-browser"], cwd=folder, stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True)
        try:
            page.open(server.stdout.readline().strip(), width=1400, height=1000)
            page.until("!!view.campaign && !!fit.told && document.querySelector('#fit-work').hidden", 600)
            page.until("!!document.querySelector('#overlay svg')")
            shot(page, out / "page.png", 1400, 1300, scale=0.6)
        finally:
            server.terminate()
            server.wait(timeout=20)
        scratch.write_text(cells(ROOT / "docs" / "gallery" / "first-fit.ipynb", 4), encoding="utf-8")
        page.open(scratch, width=900, height=400)
        shot(page, out / "notebook.png", 900, 1100)
    page.close()


if __name__ == "__main__":
    main()
