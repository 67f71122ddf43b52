"""Drives Chromium headless through chromedriver's WebDriver interface; the standard library only."""

import base64
import json
import re
import shutil
import subprocess
import tempfile
import urllib.error
import urllib.request

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"
KEYS = {"left": "\ue012", "up": "\ue013", "right": "\ue014", "down": "\ue015", "home": "\ue011"}


class Browser:
    """A headless window. Use it in a `with` block; chromedriver and the profile go with it."""

    def __init__(self, width=1280, height=900, mobile=False):
        self.driver = self.session = None
        self.profile = tempfile.TemporaryDirectory(prefix="lamella-browser-")
        program = shutil.which("chromedriver")
        if not program:
            raise RuntimeError("chromedriver is missing: apt-get install chromium chromium-driver")
        self.driver = subprocess.Popen([program, "--port=0"], stdout=subprocess.PIPE, text=True)
        for line in self.driver.stdout:
            found = re.search(r"started successfully on port (\d+)", line)
            if found:
                self.root = f"http://127.0.0.1:{found.group(1)}"
                break
        else:
            raise RuntimeError("chromedriver did not start")
        options = {"args": ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                            f"--window-size={width},{height}", f"--user-data-dir={self.profile.name}"]}
        if mobile:
            options["mobileEmulation"] = {"deviceMetrics": {"width": width, "height": height, "pixelRatio": 2.0,
                                                            "touch": True}}
        reply = self._call("POST", "/session", {"capabilities": {"alwaysMatch": {
            "browserName": "chrome", "goog:loggingPrefs": {"browser": "ALL"}, "goog:chromeOptions": options}}})
        self.session = reply["sessionId"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            if self.session:
                self._call("DELETE", f"/session/{self.session}")
        finally:
            if self.driver:
                self.driver.terminate()
                self.driver.wait(20)
                self.driver.stdout.close()
            self.profile.cleanup()

    def _call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.root + path, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=120) as reply:
                return json.load(reply)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(f"{method} {path}: {error.read().decode()[:500]}") from None

    def _do(self, method, path, body=None):
        return self._call(method, f"/session/{self.session}{path}", body)

    def open(self, url):
        self._do("POST", "/url", {"url": url})

    def run(self, script, *args):
        """The value of a function body; a promise is awaited."""
        body = "const done = arguments[arguments.length - 1]; Promise.resolve((function() {%s}).apply(null, arguments))" \
               ".then((v) => done({value: v}), (e) => done({error: String(e)}));" % script
        reply = self._do("POST", "/execute/async", {"script": body, "args": list(args)})
        if "error" in reply:
            raise RuntimeError(reply["error"])
        return reply.get("value")

    def messages(self):
        """Console messages and failed loads since the last call."""
        return self._do("POST", "/se/log", {"type": "browser"})

    def element(self, selector):
        return self._do("POST", "/element", {"using": "css selector", "value": selector})[ELEMENT]

    def click(self, selector):
        self._do("POST", f"/element/{self.element(selector)}/click", {})

    def press(self, selector, *names):
        self._do("POST", f"/element/{self.element(selector)}/value", {"text": "".join(KEYS[n] for n in names)})

    def drag(self, selector, dx, dy, pointer="mouse"):
        """From the middle of an element by dx, dy CSS pixels, in a few moves as a hand does."""
        origin = {ELEMENT: self.element(selector)}
        actions = [{"type": "pointerMove", "origin": origin, "x": 0, "y": 0}, {"type": "pointerDown", "button": 0}]
        actions += [{"type": "pointerMove", "duration": 20, "origin": origin, "x": round(dx * i / 4),
                     "y": round(dy * i / 4)} for i in range(1, 5)]
        actions += [{"type": "pointerUp", "button": 0}]
        self._do("POST", "/actions", {"actions": [{"type": "pointer", "id": pointer,
                                                   "parameters": {"pointerType": pointer}, "actions": actions}]})

    def screenshot(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self._do("GET", "/screenshot")))

    def whole_page(self, path, width=1280):
        """A picture of the page at its full height."""
        height = self.run("return document.documentElement.scrollHeight;")
        self._do("POST", "/goog/cdp/execute", {"cmd": "Emulation.setDeviceMetricsOverride", "params": {
            "width": width, "height": min(height, 16000), "deviceScaleFactor": 1, "mobile": False}})
        self.screenshot(path)
        self._do("POST", "/goog/cdp/execute", {"cmd": "Emulation.clearDeviceMetricsOverride", "params": {}})
