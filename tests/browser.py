"""A headless Chromium that a test drives over its DevTools protocol."""

from __future__ import annotations

import base64
import itertools
import json
import shutil
import subprocess
import time
import urllib.request
from pathlib import Path
from types import TracebackType
from typing import Any

import pytest
from websockets.sync.client import connect

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
NEEDED = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
"""Mark of a test that looks at a page: people test on machines without a browser, while CI installs one."""
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--hide-scrollbars",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-background-timer-throttling",
    "--disable-backgrounding-occluded-windows",
    "--disable-renderer-backgrounding",
)
DRIVEN = ("--remote-debugging-port=0", "--remote-allow-origins=*")


class Tab:
    """One page of a browser."""

    def __init__(self, address: str) -> None:
        self._socket = connect(address, max_size=None)
        self._numbers = itertools.count(1)
        self.complaints: list[str] = []
        self("Runtime.enable")
        self("Page.enable")

    def __call__(self, method: str, **parameters: Any) -> dict[str, Any]:
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self._socket.recv(timeout=60.0))
            if message.get("id") == number:
                assert "error" not in message, message
                return dict(message.get("result", {}))
            if message.get("method") == "Runtime.exceptionThrown":
                self.complaints.append(json.dumps(message["params"])[:500])

    def open(self, address: str) -> None:
        self("Page.navigate", url=address)

    def get(self, script: str) -> Any:
        """Return the value of a JavaScript expression."""
        result = self("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def wait(self, script: str, timeout: float = 30.0) -> None:
        """Wait until a JavaScript expression is true."""
        deadline = time.monotonic() + timeout
        while not self.get(script):
            assert time.monotonic() < deadline, f"{script}\n{self.text[:3000]}"
            time.sleep(0.1)

    @property
    def text(self) -> str:
        """What a reader sees."""
        return str(self.get("document.body ? document.body.innerText : ''"))

    def wait_for(self, text: str, timeout: float = 30.0) -> None:
        """Wait until a text can be read."""
        self.wait(f"document.body && document.body.innerText.includes({json.dumps(text)})", timeout)

    def click(self, text: str, within: str = "button") -> None:
        """Press the last button with a text: that of the dialog on top."""
        buttons = f"[...document.querySelectorAll({json.dumps(within)})]"
        found = f"{buttons}.filter(b => b.innerText.trim().toLowerCase() === {json.dumps(text.lower())}).pop()"
        self.wait(f"(b => b && !b.disabled)({found})")
        self.get(f"{found}.click()")

    def write(self, text: str) -> None:
        """Type into the field that a dialog has last opened."""
        self.wait("document.querySelectorAll('.q-dialog input').length === 1")  # one that closes is still there
        field = "document.querySelector('.q-dialog input')"
        typed = f"{field}.value = {json.dumps(text)}"
        self.get(f"{typed}; {field}.dispatchEvent(new Event('input', {{ bubbles: true }}))")

    def size(self, width: int, height: int) -> None:
        self("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)

    def picture(self, path: Path) -> None:
        shot = self("Page.captureScreenshot", format="png", captureBeyondViewport=False)
        path.write_bytes(base64.b64decode(shot["data"]))

    def close(self) -> None:
        self._socket.close()


class Browser:
    """A browser of its own; a context manager."""

    def __init__(self, profile: Path) -> None:
        assert CHROMIUM is not None
        self._process = subprocess.Popen(
            [CHROMIUM, *FLAGS, *DRIVEN, f"--user-data-dir={profile}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        port = profile / "DevToolsActivePort"
        deadline = time.monotonic() + 60.0
        while not (port.exists() and port.read_text().strip()):
            assert time.monotonic() < deadline, "no browser"
            time.sleep(0.1)
        self._port = int(port.read_text().split()[0])

    def tab(self) -> Tab:
        request = urllib.request.Request(f"http://127.0.0.1:{self._port}/json/new?about:blank", method="PUT")
        with urllib.request.urlopen(request, timeout=30.0) as answer:
            return Tab(json.load(answer)["webSocketDebuggerUrl"])

    def __enter__(self) -> Browser:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._process.terminate()
        self._process.wait(30.0)
