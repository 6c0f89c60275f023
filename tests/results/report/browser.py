"""Pages in Chromium without a display, through its debugging pipe."""

import base64
import json
import os
import shutil
import subprocess
import time
from contextlib import contextmanager

import pytest

NAMES = "chromium", "chromium-browser", "google-chrome", "chrome"
LONGEST = 120.0  # s, of an answer
WEBGL = "--use-angle=swiftshader", "--enable-unsafe-swiftshader"


class Page:
    """A page with its messages."""

    def __init__(self, read, write):
        self._read, self._write, self._number = read, write, 0
        self._buffer, self.events, self._session = b"", [], None

    def call(self, method, **parameters):
        """Call a method of the browser, and return its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]
            self.events.append(answer)

    def _receive(self):
        while b"\0" not in self._buffer:
            part = os.read(self._read, 1 << 20)
            assert part, "the browser ended"
            self._buffer += part
        text, _, self._buffer = self._buffer.partition(b"\0")
        return json.loads(text)

    def open(self, address, size):
        """Open an address, and wait until it is loaded."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for name in ("Runtime", "Log", "Network", "Page"):
            self.call(f"{name}.enable")
        width, height = size
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=1, mobile=False,
        )  # fmt: skip
        self.call("Page.navigate", url=address)
        begin = time.monotonic()
        while self.run("document.readyState + location.href").startswith("completeabout"):
            assert time.monotonic() - begin < LONGEST
            time.sleep(0.05)
        self.run("new Promise(r => document.readyState === 'complete' ? r() : onload = () => r())")

    def in_frames(self, script):
        """Return the values of a script in all frames of the page that have own processes."""
        self.call(
            "Target.setAutoAttach", autoAttach=True, waitForDebuggerOnStart=False, flatten=True
        )
        attached = [e["params"] for e in self.events if e["method"] == "Target.attachedToTarget"]
        frames = [e["sessionId"] for e in attached if e["targetInfo"]["type"] == "iframe"]
        page, values = self._session, []
        for self._session in frames:
            self.call("Log.enable")
            values.append(self.run(script))
        self._session = page
        return values

    def run(self, script):
        """Return the value of a script, also of a promise."""
        result = self.call(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    @property
    def messages(self):
        """Messages on the console, errors and warnings of the browser."""
        kinds = "Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"
        return [each["params"] for each in self.events if each.get("method") in kinds]

    @property
    def requests(self):
        """Addresses that the page requested, other than parts of itself."""
        every = [e["params"] for e in self.events if e.get("method") == "Network.requestWillBeSent"]
        return [e["request"]["url"] for e in every if not e["request"]["url"].startswith("blob:")]

    def save_picture(self, path, *, full=False):
        """Write a picture of the page."""
        data = self.call("Page.captureScreenshot", captureBeyondViewport=full)["data"]
        path.write_bytes(base64.b64decode(data))


@contextmanager
def open_page(path, folder, *, size=(1200, 900), options=WEBGL, fragment=""):
    """Open a file or an address in Chromium; the test is skipped where there is none."""
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip("Chromium is not installed")
    (inside, write), (read, outside) = os.pipe(), os.pipe()
    arguments = [
        program, "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", *options,
        "--remote-debugging-pipe", f"--user-data-dir={folder}", "--no-first-run",
        "--disable-extensions", "--disable-background-networking", "--mute-audio",
    ]  # fmt: skip

    def take_pipes():
        # By way of copies, since one of the pipes may be number 3 or 4 itself.
        for number, end in zip((3, 4), [os.dup(inside), os.dup(outside)], strict=True):
            os.dup2(end, number)

    process = subprocess.Popen(
        arguments, close_fds=False, preexec_fn=take_pipes,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        page = Page(read, write)
        address = path if isinstance(path, str) else path.absolute().as_uri()
        page.open(address + fragment, size)
        yield page
    finally:
        process.terminate()
        process.wait(timeout=20)
        for end in (inside, write, read, outside):
            os.close(end)
