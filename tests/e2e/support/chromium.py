"""Headless Chromium, driven by the DevTools protocol over a WebSocket, with the standard library alone."""
import atexit
import base64
import json
import os
import shutil
import socket
import struct
import subprocess
import tempfile
import time
import urllib.request

from image_reader import Failure, check

HANG_S = 120


class WebSocketClient:
    """Client side of RFC 6455, as far as the tests need it: whole texts, close codes, no extensions."""

    def __init__(self, host, port, path, origin=None, host_header=None, more=()):
        """more: further lines of the request's head."""
        self.socket = socket.create_connection((host, port), timeout=HANG_S)
        self.received = b""
        lines = [f"GET {path} HTTP/1.1", f"Host: {host_header or f'{host}:{port}'}", "Upgrade: websocket", "Connection: Upgrade",
                 "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode()]
        if origin:
            lines.append(f"Origin: {origin}")
        lines += more
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        while b"\r\n\r\n" not in self.received:
            if not self._more():
                break
        head, _, self.received = self.received.partition(b"\r\n\r\n")
        self.status = int(head.split()[1]) if head.startswith(b"HTTP/") else 0

    def _more(self):
        data = self.socket.recv(1 << 16)
        self.received += data
        return bool(data)

    def send(self, text):
        data = text.encode()
        size = struct.pack(">B", 0x80 | len(data)) if len(data) < 126 else struct.pack(">BH", 0x80 | 126, len(data)) \
            if len(data) < 1 << 16 else struct.pack(">BQ", 0x80 | 127, len(data))
        self.socket.sendall(b"\x81" + size + bytes(4) + data)  # a mask of zeros

    def _take(self, count):
        while len(self.received) < count:
            if not self._more():
                raise Failure("the WebSocket ended")
        data, self.received = self.received[:count], self.received[count:]
        return data

    def receive(self):
        """The next message: (opcode, payload), fragments joined; opcode 8 is a close."""
        whole, kind = b"", 0
        while True:
            first, second = self._take(2)
            size = second & 127
            if size >= 126:
                size = struct.unpack(">H" if size == 126 else ">Q", self._take(2 if size == 126 else 8))[0]
            payload = self._take(size)
            kind = first & 15 or kind
            if kind in (9, 10):
                if kind == 9:  # the server ends silent connections
                    self.socket.sendall(b"\x8a" + struct.pack(">B", 0x80 | size) + bytes(4) + payload)
                kind = 0
                continue
            whole += payload
            if first & 0x80:
                return kind, whole

    def close_code(self):
        """The code of the server's close, after any messages."""
        while True:
            kind, payload = self.receive()
            if kind == 8:
                return struct.unpack(">H", payload[:2])[0]

    def close(self):
        self.socket.close()


class Page:
    """One tab of the browser."""

    def __init__(self, browser, target):
        self.browser, self.number = browser, 0
        path = "/" + target["webSocketDebuggerUrl"].split("/", 3)[3]
        self.connection = WebSocketClient("127.0.0.1", browser.port, path)
        check(self.connection.status == 101, "Chromium's DevTools refuse the connection")
        self.errors = []
        self.call("Runtime.enable")
        self.call("Log.enable")
        self.call("Page.enable")
        self.call("Emulation.setFocusEmulationEnabled", enabled=True)

    def call(self, method, **parameters):
        self.number += 1
        self.connection.send(json.dumps({"id": self.number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self.connection.receive()[1])
            if message.get("method") == "Runtime.exceptionThrown":
                self.errors.append(json.dumps(message["params"]["exceptionDetails"])[:500])
            if message.get("method") == "Log.entryAdded" and message["params"]["entry"]["level"] == "error":
                self.errors.append(message["params"]["entry"]["text"])
            if message.get("id") == self.number:
                check("error" not in message, f"{method}: {message.get('error')}")
                return message["result"]

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        check("exceptionDetails" not in result, f"{expression}: {result.get('exceptionDetails')}")
        return result["result"].get("value")

    def size(self, width, height, ratio=1, touch=False, scheme=None):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=ratio, mobile=touch)
        self.call("Emulation.setTouchEmulationEnabled", enabled=touch)
        if scheme:
            self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def open(self, url):
        self.call("Page.navigate", url=url)
        self.wait("the page", "location.href !== 'about:blank' && document.readyState === 'complete'")

    def mouse(self, kind, x, y, button="left", **more):
        buttons = 0 if kind in ("mouseReleased", "mouseWheel") else {"left": 1, "right": 2}[button]
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="none" if kind == "mouseWheel" else button, buttons=buttons, clickCount=1,
                  **more)

    def click(self, x, y):
        self.mouse("mousePressed", x, y)
        self.mouse("mouseReleased", x, y)

    def drag(self, start, end, button="left"):
        self.mouse("mousePressed", *start, button=button)
        for i in range(1, 5):
            self.mouse("mouseMoved", start[0] + (end[0] - start[0]) * i / 4, start[1] + (end[1] - start[1]) * i / 4, button=button)
        self.mouse("mouseReleased", *end, button=button)

    def touch(self, kind, *points):
        self.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)])

    def key(self, key, code=None, modifiers=0):
        text = {"text": key} if len(key) == 1 else {}
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code or key, modifiers=modifiers, **(text if kind == "keyDown" else {}))

    def downloads_to(self, folder):
        self.call("Page.setDownloadBehavior", behavior="allow", downloadPath=folder)

    def screenshot(self, path):
        data = self.call("Page.captureScreenshot", format="png")["data"]
        with open(path, "wb") as file:
            file.write(base64.b64decode(data))

    def wait(self, what, expression, hang_s=HANG_S):
        """Polls until the expression is true in the page, and returns its value."""
        end = time.monotonic() + hang_s
        while True:
            value = self.evaluate(expression)
            if value:
                return value
            if time.monotonic() > end:
                text = self.evaluate("document.body ? document.body.innerText : ''")[:400]
                raise Failure(f"waited {hang_s} s in vain for: {what}; errors: {self.errors}; the page says: {text}")
            time.sleep(0.05)


class Chromium:
    """A browser. Each test closes its pages; they have the renderer's address as origin and so share no state."""

    def __init__(self, folder, *options):
        program = shutil.which("chromium") or shutil.which("chromium-browser")
        check(program, "chromium is not installed")
        profile = os.path.join(folder, "chromium")
        self.process = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", "--force-color-profile=srgb",
             "--remote-debugging-port=0", f"--user-data-dir={profile}", *options, "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end, port_file = time.monotonic() + HANG_S, os.path.join(profile, "DevToolsActivePort")
        while not (os.path.exists(port_file) and open(port_file).read().count("\n") >= 1):
            check(self.process.poll() is None and time.monotonic() < end, "Chromium does not start")
            time.sleep(0.05)
        self.port = int(open(port_file).read().split("\n")[0])

    def _get(self, command, method="GET", text=False):
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}/json/{command}", method=method)
        with urllib.request.urlopen(request, timeout=HANG_S) as answer:
            return answer.read() if text else json.load(answer)

    def page(self):
        return Page(self, self._get("new?about:blank", method="PUT"))

    def close_pages(self):
        for target in self._get("list"):
            if target["type"] == "page" and target["url"] != "about:blank":
                self._get(f"close/{target['id']}", text=True)

    def end(self):
        self.process.kill()
        self.process.wait()


def shared_chromium(*options, browsers={}):
    """One browser for all tests of this process that want these options: its start takes longer than most of them."""
    if options not in browsers:
        folder = tempfile.mkdtemp(prefix="fire3dv-chromium-")
        browsers[options] = browser = Chromium(folder, *options)
        atexit.register(lambda: (browser.end(), shutil.rmtree(folder, ignore_errors=True)))
    return browsers[options]
