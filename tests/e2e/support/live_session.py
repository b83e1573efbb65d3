"""A renderer with a live view of the robot arm, and pages of it in headless Chromium."""
import base64
import math
import os
import subprocess

from chromium import WebSocketClient, shared_chromium
from glb_edit import edit_glb
from harness import Program, vulkan_environment
from image_reader import check

WIDTH, HEIGHT = 240, 136
LEAST_PSNR_DB = 35

PIXELS = """(() => {
  const canvas = document.getElementById("canvas");
  const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  let text = "";
  for (let i = 0; i < data.length; i += 4) text += String.fromCharCode(data[i], data[i + 1], data[i + 2]);
  return [canvas.width, canvas.height, btoa(text)];
})()"""


class LiveRenderer:
    """fire3dv with --serve, and its links."""

    def __init__(self, test, *arguments, at="127.0.0.1:0", scene=None, change=None, host=None):
        """scene: file; None: the robot arm. change: see edit_glb(). host: network namespace of the renderer; None: this one."""
        self.test, self.host_of_renderer = test, host
        self.scene = scene or test.path("arm.glb")
        if not os.path.exists(self.scene):
            subprocess.run([test.programs_at["bullet_arm"], "--write-scene", self.scene], check=True, stdout=subprocess.DEVNULL)
        if change:
            edit_glb(self.scene, self.scene, change)
        self.renderer = None
        self.start(at, *arguments)

    def start(self, at, *arguments):
        shadows = () if "--render" in arguments else ("--shadows", "map")
        self.renderer = Program(self.test, "fire3dv", [
            self.test.programs_at["fire3dv"], self.scene, "--headless", "--serve", at, "--size", "32x32", *shadows,
            "--validation", "--cache", "off", *arguments], vulkan_environment(), self.host_of_renderer)
        self.control = self.renderer.wait_err(r"^  control  (https?://\S+/#[0-9a-f]{32})$").group(1)
        self.view = self.renderer.wait_err(r"^  view     (https?://\S+/#[0-9a-f]{32})$").group(1)
        self.host = self.control.split("/")[2]

    def viewer(self, width, height, h264=False, link=None):
        """A viewer without a browser, whose canvas has this size. link: None: the control link."""
        host, port = self.host.split(":")
        client = WebSocketClient(host, int(port), "/socket", origin=f"http://{self.host}")
        check(client.status == 101, f"no WebSocket: {client.status}")
        client.send('{"type":"hello","token":"%s"}' % (link or self.control).split("#")[1])
        while b'"welcome"' not in client.receive()[1]:  # earlier messages are lost while the renderer starts
            pass
        if h264:
            client.send('{"type":"codec","h264":true}')
        client.send('{"type":"size","width":%d,"height":%d}' % (width, height))
        return client


class Session(LiveRenderer):
    """A live view, and a browser."""

    def __init__(self, test, *arguments, browser=(), **options):
        super().__init__(test, *arguments, **options)
        self.browser = shared_chromium(*browser)

    def page(self, link=None, embed=True, size=(WIDTH, HEIGHT), **options):
        page = self.browser.page()
        page.size(*size, **options)
        link = link or self.control
        page.open(link.replace("/#", "/?embed=1#") if embed else link)
        return page

    def end(self):
        self.browser.close_pages()


def image_after(page, number):
    """Waits until an image of full quality, later than this one, is on the canvas; returns its number."""
    image = "JSON.parse(document.getElementById('canvas')?.dataset.image ?? '{}')"
    return page.wait(f"a refined image after {number}", f"(() => {{ const i = {image}; return i.refined && i.number > {number} && i.number; }})()")


def canvas(page):
    width, height, text = page.evaluate(PIXELS)
    return width, height, base64.b64decode(text)


def psnr_db(a, b):
    check(len(a) == len(b), f"{len(a)} and {len(b)} bytes")
    error = sum((x - y) ** 2 for x, y in zip(a, b)) / len(a)
    return 99 if error == 0 else 10 * math.log10(255 ** 2 / error)
