"""A headless chromium for the system tests of pages."""

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time

from harness import DEADLINE_S

CHROMIUM = shutil.which("chromium")


class Browser:
    """A headless chromium without access to any network, unless `reachable` is an exception, controlled by its DevTools protocol over two pipes."""

    def __init__(self, test, reachable="~NOTFOUND"):
        self.errors, self.requests, self.numbers, self.waiting = [], [], iter(range(1, 1 << 30)), []
        to_read, self.to = os.pipe()
        self.from_, to_write = os.pipe()
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 64) for end in (to_read, to_write)]  # numbers other than 3 and 4
        def place():
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)
        self.process = subprocess.Popen(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-extensions", "--hide-scrollbars",
             f"--host-resolver-rules=MAP * {reachable}", "--remote-debugging-pipe", "--user-data-dir=" + test.path("browser")],
            preexec_fn=place, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
        for end in (to_read, to_write, *ends):
            os.close(end)
        self.received, self.session = b"", None
        test.addCleanup(self.close)
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self.to)
        os.close(self.from_)

    def next_message(self, end):
        while b"\0" not in self.received:
            if not select.select([self.from_], [], [], max(0.0, end - time.monotonic()))[0]:
                raise AssertionError(f"chromium sent nothing for {DEADLINE_S:g} s")
            data = os.read(self.from_, 1 << 20)
            assert data, "chromium has ended"
            self.received += data
        message, self.received = self.received.split(b"\0", 1)
        return json.loads(message)

    def wait_for(self, accept):
        """Returns the first message for which `accept` is true. Keeps the errors and requests that all messages report."""
        end = time.monotonic() + DEADLINE_S
        while True:
            message = self.next_message(end)
            method, parameters = message.get("method"), message.get("params", {})
            if method == "Network.requestWillBeSent":
                self.requests.append(parameters["request"]["url"])
            elif method == "Runtime.exceptionThrown":
                self.errors.append(parameters["exceptionDetails"]["text"])
            elif method == "Runtime.consoleAPICalled":
                self.errors.append(str(parameters["args"]))
            elif method == "Log.entryAdded":
                self.errors.append(parameters["entry"]["text"])
            if accept(message):
                return message

    def call(self, method, **parameters):
        number = next(self.numbers)
        message = {"id": number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        answer = self.wait_for(lambda m: m.get("id") == number)
        assert "error" not in answer, answer
        return answer["result"]

    def open(self, place, width, scheme):
        """Opens a file by its path, or a URL."""
        self.errors, self.requests = [], []
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 800)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.call("Page.navigate", url=place if "://" in place else "file://" + place)
        self.wait_for(lambda m: m.get("method") == "Page.loadEventFired")

    def value(self, expression):
        return self.call("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def screenshot(self, path):
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        shot = self.call("Page.captureScreenshot", format="png", clip=clip, captureBeyondViewport=True)
        with open(path, "wb") as file:
            file.write(base64.b64decode(shot["data"]))
