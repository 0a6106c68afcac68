"""A headless Chromium driven over its DevTools protocol through a pipe; the standard library is enough for that."""

import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path


def find() -> str | None:
    """The browser: HYDROSYSID_CHROMIUM, or the first known name on the path."""
    named = os.environ.get("HYDROSYSID_CHROMIUM")
    known = ("chromium", "chromium-browser", "google-chrome", "chrome")
    return named or next(filter(None, map(shutil.which, known)), None)


class Page:
    """One page. Console messages of kind error, and uncaught exceptions, gather in `errors`; requests in `urls`."""

    def __init__(self, program: str):
        self.errors: list[str] = []
        self.urls: list[str] = []
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self._number = 0
        self._heard: dict[str, dict] = {}
        to_browser, self._write = os.pipe()
        self._read, from_browser = os.pipe()
        # The browser reads commands from descriptor 3 and writes answers to 4.
        arguments = [program, "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                     "--remote-debugging-pipe", "--no-first-run", f"--user-data-dir={self._profile.name}"]
        shell = f'exec 3<&{to_browser} 4>&{from_browser}; exec "$@"'
        self._process = subprocess.Popen(["bash", "-c", shell, "browser", *arguments],
                                         pass_fds=(to_browser, from_browser),
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self._rest = b""
        self._session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def close(self) -> None:
        self._session = None
        try:
            self.call("Browser.close")
        except (EOFError, BrokenPipeError):
            pass
        os.close(self._write)
        os.close(self._read)
        self._process.wait(timeout=30)
        self._profile.cleanup()

    def call(self, method: str, **parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]

    def _next(self) -> dict:
        while b"\0" not in self._rest:
            chunk = os.read(self._read, 1 << 20)
            if not chunk:
                raise EOFError("the browser has gone")
            self._rest += chunk
        text, self._rest = self._rest.split(b"\0", 1)
        message = json.loads(text)
        self._note(message.get("method"), message.get("params", {}))
        return message

    def _note(self, method: str | None, params: dict) -> None:
        if method in ("Page.loadEventFired", "Page.fileChooserOpened"):
            self._heard[method] = params
        if method == "Runtime.exceptionThrown":
            self.errors.append(json.dumps(params["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning"):
            self.errors.append(json.dumps(params["args"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            self.errors.append(params["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.urls.append(params["request"]["url"])

    def wait_for(self, method: str) -> dict:
        """What an event of this name says: the one that came last and was not asked for yet, else the next."""
        while method not in self._heard:
            self._next()
        return self._heard.pop(method)

    def open(self, file: Path | str, width: int = 1000, height: int = 900, dark: bool = False, script: bool = True) -> None:
        """Opens a file or an address and waits until it is loaded."""
        # The page before may have lost its server and complain of it for as long as it is open: it is left first.
        self._go("about:blank")
        self.errors.clear()
        self.urls.clear()
        self.call("Emulation.setScriptExecutionDisabled", value=not script)
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        feature = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[feature])
        self._go(file if isinstance(file, str) else file.resolve().as_uri())

    def _go(self, url: str) -> None:
        self._heard.clear()
        self.call("Page.navigate", url=url)
        self.wait_for("Page.loadEventFired")

    def run(self, expression: str):
        """Value of a JavaScript expression."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(json.dumps(answer["exceptionDetails"]))
        return answer["result"].get("value")

    def until(self, expression: str, seconds: float = 120):
        """Waits until a JavaScript expression is true; how long that took, s."""
        begun = time.monotonic()
        while not self.run(expression):
            if time.monotonic() - begun > seconds:
                raise TimeoutError(expression)
            time.sleep(0.02)
        return time.monotonic() - begun

    def press(self, key: str, shift: bool = False) -> None:
        """Presses a key and lets it go: a character, or a name such as Tab."""
        code = {"Tab": 9, "Enter": 13, "Escape": 27, " ": 32, "ArrowDown": 40, "Backspace": 8, ".": 190}.get(key)
        text = {"Enter": "\r"}.get(key, key if len(key) == 1 else "")
        more = {"windowsVirtualKeyCode": code if code else ord(key.upper()), "modifiers": 8 if shift else 0}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, text=text, **more)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, **more)

    def mouse(self, kind: str, x: float, y: float, **more) -> None:
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)
