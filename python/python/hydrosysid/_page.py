"""The verb `view`: a page in the browser, served by the command."""

from __future__ import annotations

import atexit
import html
import subprocess
import sys
import tempfile
import webbrowser
from os import PathLike, fspath
from types import TracebackType

from ._errors import UsageError


class View:
    """A page that is served only to this machine, until `stop()` or the end of the program.

    Attributes:
        address: address of the page, with the access token.
    """

    def __init__(self, server: subprocess.Popen[str], address: str) -> None:
        self._server = server
        self.address = address

    @property
    def is_served(self) -> bool:
        """Whether the page still answers."""
        return self._server.poll() is None

    def stop(self) -> None:
        """Stops serving the page; the campaign file already has every change."""
        if self.is_served:
            self._server.terminate()
        self._server.wait(timeout=30)
        if self._server.stdout is not None:
            self._server.stdout.close()
        atexit.unregister(self.stop)

    def __enter__(self) -> View:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.stop()

    def __repr__(self) -> str:
        return f"View({self.address!r})" if self.is_served else "View(ended)"

    def _repr_html_(self) -> str:
        address = html.escape(self.address)
        return f'<a href="{address}" target="_blank">{address}</a>' if self.is_served else "<p>ended</p>"


def view(campaign: str | PathLike[str], *, port: int = 0, browser: bool = True) -> View:
    """Serves a page to work on a campaign: logs, columns, stretches, effects, discovery, report.

    Every change is written into the campaign file, comments are kept. The page is served alongside this program, until
    `View.stop` is called, a ``with`` block ends, or the program does.

    Args:
        campaign: campaign file, or a folder for one.
        port: port of 127.0.0.1; any free one when 0.
        browser: open the page in the browser.

    Raises:
        UsageError: there is no such folder, or the port cannot be used.
    """
    words = ["view", fspath(campaign), "--port", str(port), "--no-browser"]
    # a file takes all that is said there, whether anybody reads it or not
    with tempfile.TemporaryFile("w+", encoding="utf-8") as said:
        command = [sys.executable, "-m", "hydrosysid", *words]
        server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=said, text=True, encoding="utf-8")
        address = server.stdout.readline().strip() if server.stdout is not None else ""
        page = View(server, address)
        if not address:
            page.stop()
            said.seek(0)
            raise UsageError(said.read().strip().removeprefix("error: "))
    atexit.register(page.stop)
    if browser:
        webbrowser.open(address)
    return page
