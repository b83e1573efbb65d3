#!/usr/bin/env python3
"""End-to-end test of --serve: the page in headless Chromium shows what the renderer draws, follows input, and keeps others out."""
import base64
import os
import signal
import subprocess

from chromium import WebSocketClient
from harness import Program, main, vulkan_environment, wait_until
from image_reader import Failure, check, read_png
from live_session import HEIGHT, LEAST_PSNR_DB, PIXELS, WIDTH, Session, canvas, image_after, psnr_db
from mcap_file import McapFile, body_of, pose_frame
from prometheus import scrape, url_of
from reverse_proxy import ReverseProxy


def image(test):
    """The canvas shows the image that the renderer writes to a file."""
    session = Session(test)
    try:
        page = session.page()
        image_after(page, 0)
        width, height, shown = canvas(page)
        check((width, height) == (WIDTH, HEIGHT), f"the canvas has {width} x {height} pixels")
        folder = test.path("png")
        subprocess.run([test.programs_at["fire3dv"], session.scene, "--headless", "--frames", "1", "--size", f"{WIDTH}x{HEIGHT}", "--shadows", "map",
                        "--out", folder, "--cache", "off"], check=True, env=vulkan_environment(), stderr=subprocess.DEVNULL)
        written = b"".join(bytes(row) for row in read_png(os.path.join(folder, "frame_000000.png")).rows)
        got = psnr_db(shown, written)
        check(got > LEAST_PSNR_DB, f"the PSNR of the canvas and the file is {got:.1f} dB")
        check(len(set(written)) > 50, "the image is empty")
        check(not page.errors, f"errors of the page: {page.errors}")
    finally:
        session.end()


# Records the messages of the page to the renderer.
RECORD = """(() => {
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (data) {
    if (typeof data === "string") window.sent.push(JSON.parse(data));
    return send.call(this, data);
  };
})()"""
TWO_FRAMES = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"


def arrow_keys(page, at):
    """Each arrow key moves the camera as a drag in its direction does: turns it, or with Shift pans; and only until it is released."""
    page.evaluate(RECORD)

    def moves(kind, act):
        """Sum of each number of the messages of this kind."""
        nonlocal at
        before = canvas(page)[2]
        page.evaluate("window.sent = []")
        act()
        at = image_after(page, at)
        page.evaluate(TWO_FRAMES)
        sent = page.evaluate("window.sent.filter((message) => message.type !== 'shown' && message.type !== 'log')")
        check(sent and all(message["type"] in (kind, "camera") for message in sent), f"not {kind}: {sent}")
        check(psnr_db(before, canvas(page)[2]) < 60, f"{sent} does not change the image")
        page.evaluate(TWO_FRAMES)
        later = page.evaluate("window.sent.filter((message) => message.type !== 'shown' && message.type !== 'log')")
        check(len(later) == len(sent), f"the camera moves on: {later[len(sent):]}")
        return [sum(message.get(name, 0) for message in sent) for name in (("yaw", "pitch") if kind == "orbit" else ("right", "up"))]
    for modifiers, kind in ((0, "orbit"), (8, "pan")):
        for axis, keys, end in ((0, ("ArrowLeft", "ArrowRight"), (100, 70)), (1, ("ArrowUp", "ArrowDown"), (120, 50))):
            by_drag = moves(kind, lambda: page.drag((120, 70), end, button="right" if modifiers else "left"))
            for key, sign in zip(keys, (1, -1)):
                by_key = moves(kind, lambda: page.key(key, modifiers=modifiers))
                check(sign * by_key[axis] * by_drag[axis] > 0 and by_key[1 - axis] == 0, f"{key} of {kind}: {by_key}, a drag: {by_drag}")
    # + is Shift and =; whoever releases Shift first must not zoom for ever.
    page.evaluate("window.sent = []")
    page.call("Input.dispatchKeyEvent", type="keyDown", key="+", code="Equal", modifiers=8, text="+")
    page.call("Input.dispatchKeyEvent", type="keyUp", key="=", code="Equal")
    page.evaluate(TWO_FRAMES)
    zooms = "window.sent.filter((message) => message.type === 'zoom').length"
    count = page.evaluate(zooms)
    check(count > 0, "+ does not zoom")
    page.evaluate(TWO_FRAMES)
    check(page.evaluate(zooms) == count, "the zoom goes on after the key is released")
    return image_after(page, at)


def cameras(test):
    """Each viewer has a camera of its own, which mouse, wheel, keys and fingers move."""
    session = Session(test)
    try:
        first, second = session.page(), session.page(session.view)
        at_first, at_second = image_after(first, 0), image_after(second, 0)
        before, before_second = canvas(first)[2], canvas(second)[2]
        check(psnr_db(before, before_second) > LEAST_PSNR_DB, "two new viewers see different images")
        first.call("Page.bringToFront")  # a page in the background gets no frames
        moves = (("a drag", lambda: first.drag((120, 90), (180, 100))),
                 ("the wheel", lambda: first.mouse("mouseWheel", 100, 100, deltaX=0, deltaY=-300)),
                 ("a drag with the right button", lambda: first.drag((120, 90), (150, 90), button="right")),
                 ("a key", lambda: first.key("ArrowLeft")))
        for what, move in moves:
            move()
            at_first = image_after(first, at_first)
            after = canvas(first)[2]
            check(psnr_db(before, after) < LEAST_PSNR_DB, f"{what} does not move the camera")
            before = after
        at_first = arrow_keys(first, at_first)
        before = canvas(first)[2]
        first.size(WIDTH, HEIGHT, touch=True)
        first.touch("touchStart", (100, 100), (140, 100))
        for i in range(1, 5):
            first.touch("touchMove", (100 - 8 * i, 100), (140 + 8 * i, 100))
        first.touch("touchEnd")
        at_first = image_after(first, at_first)
        check(psnr_db(before, canvas(first)[2]) < LEAST_PSNR_DB, "a pinch does not zoom")
        check(psnr_db(canvas(second)[2], before_second) == 99, "another viewer's camera has moved")
        image = "JSON.parse(document.getElementById('canvas').dataset.image).number"
        check(second.evaluate(image) == at_second, "a viewer whose view stands gets images")
        first.key("Home")
        image_after(first, at_first)
    finally:
        session.end()


STEP = 6  # pixels between samples of a reduced image


def reduced(page):
    """Green of every STEPth pixel, as rows."""
    width, height, data = canvas(page)
    return [[data[3 * (y * width + x) + 1] for x in range(0, width, STEP)] for y in range(0, height, STEP)]


def flat(rows):
    return bytes(value for row in rows for value in row)


def best_fit(before, after, candidates, place):
    """The candidate for which after[place(candidate, x, y)] differs least from before[y][x]."""
    def difference(candidate):
        errors = []
        for y, row in enumerate(before):
            for x, value in enumerate(row):
                at_x, at_y = place(candidate, x, y)
                if 0 <= at_x < len(row) and 0 <= at_y < len(before):
                    errors.append(abs(after[at_y][at_x] - value))
        return sum(errors) / len(errors)
    return min(candidates, key=difference)


def touch(test):
    """At a telephone's size two fingers zoom about their middle and pan with the scene under them, one finger turns; the page stays."""
    session = Session(test)
    size = (390, 780)
    try:
        page = session.page(size=size, touch=True)
        number = image_after(page, 0)

        def gesture(*fingers):
            """Each finger goes from its first position to its second."""
            page.touch("touchStart", *[start for start, _ in fingers])
            for i in range(1, 9):
                page.touch("touchMove", *[(x + (to_x - x) * i / 8, y + (to_y - y) * i / 8) for (x, y), (to_x, to_y) in fingers])
            page.touch("touchEnd")
            return image_after(page, number)
        before = reduced(page)
        number = gesture(((150, 350), (210, 380)), ((250, 350), (310, 380)))
        panned = reduced(page)
        steps = range(-16, 17, 2)
        shift = best_fit(before, panned, [(dx, dy) for dx in steps for dy in steps], lambda d, x, y: (x + d[0], y + d[1]))
        check(abs(shift[0] - 60 / STEP) <= 2 and abs(shift[1] - 30 / STEP) <= 2, f"the scene moves by {[STEP * d for d in shift]} pixels, not by 60, 30")
        number = gesture(((210, 380), (150, 350)), ((310, 380), (250, 350)))
        number = gesture(((165, 390), (135, 390)), ((225, 390), (255, 390)))  # twice as far from each other
        zoomed = reduced(page)
        middle = [side / 2 / STEP for side in size]
        scales = [0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.2, 1.4, 1.6, 1.8, 2, 2.2, 2.5, 3]
        scale = best_fit(before, zoomed, scales, lambda f, x, y: (round(middle[0] + f * (x - middle[0])), round(middle[1] + f * (y - middle[1]))))
        check(1.6 <= scale <= 2.5, f"fingers that spread to twice their distance zoom by {scale}")
        number = gesture(((135, 390), (165, 390)), ((255, 390), (225, 390)))
        check(psnr_db(flat(before), flat(reduced(page))) > 30, "the gestures back do not lead back")
        number = gesture(((195, 390), (255, 390)))
        check(psnr_db(flat(before), flat(reduced(page))) < 30, "one finger does not turn the camera")
        check(page.evaluate("[visualViewport.scale, scrollX, scrollY]") == [1, 0, 0], "the page itself is zoomed or scrolled")
        check(not page.errors, f"errors of the page: {page.errors}")
    finally:
        session.end()


def nodes(test):
    """The node list: search, picking in the image, hiding for all viewers, and only with the control link."""
    session = Session(test)
    try:
        page = session.page(embed=False, size=(640, 300))
        at = image_after(page, 0)
        check(page.evaluate("document.querySelectorAll('#tree .label').length") > 0, "no nodes are listed")
        page.evaluate("document.getElementById('search').value = 'LINK'; document.getElementById('search').dispatchEvent(new Event('input'))")
        found = page.evaluate("[...document.querySelectorAll('#tree .label')].map((label) => label.textContent)")
        check(found and all("link" in name.lower() for name in found), f"the search for LINK found {found}")
        page.evaluate("document.getElementById('search').value = ''; document.getElementById('search').dispatchEvent(new Event('input'))")
        page.click(170, 170)
        name = page.wait("the picked node", "document.getElementById('selection').hidden ? '' : document.getElementById('picked-name').textContent")
        before = canvas(page)[2]
        page.wait("its position", "document.getElementById('picked-position').textContent.endsWith(' m')")
        page.wait("its rotation", "/^(-?[0-9.]+, ){2}-?[0-9.]+ °$/.test(document.getElementById('picked-rotation').textContent)")
        page.key("h")
        page.wait("it to be hidden", "document.querySelector('.node.selected.gone') !== null")
        at = image_after(page, at)
        check(psnr_db(before, canvas(page)[2]) < 60, f"hiding {name} changes nothing")
        viewer = session.page(session.view, embed=False, size=(640, 300))
        at_viewer = image_after(viewer, 0)
        check(viewer.wait("the rights", "document.getElementById('rights').textContent") == "view only", "the rights of the view link")
        hidden = canvas(page)[2]
        check(psnr_db(hidden, canvas(viewer)[2]) > LEAST_PSNR_DB, "the viewer does not see the node hidden")
        viewer.key("H", modifiers=8)  # show all: without the right, nothing happens
        viewer.key("Home")  # its answer comes after that of the key before
        image_after(viewer, at_viewer)
        check(page.evaluate("document.querySelector('.node.selected.gone') !== null"), "a viewer without control shows all nodes")
        page.key("H", modifiers=8)
        at = image_after(page, at)
        check(psnr_db(before, canvas(page)[2]) > LEAST_PSNR_DB, "show all does not bring it back")
        render(page, viewer, at)
        link(session, page, name)
        check(not page.errors and not viewer.errors, f"errors of the page: {page.errors} {viewer.errors}")
    finally:
        session.end()


def choose(page, control, what):
    """Sets a control of the page as a user does."""
    page.evaluate(f"(() => {{ const c = document.getElementById('{control}'); {what}; c.dispatchEvent(new Event('change')); }})()")


# Types of controls that the page makes of a message, and the values that they send.
NEW_SETTINGS = """(async () => {
  const {Settings} = await import("./settings.js"), sent = [];
  const list = document.createElement("div"), settings = new Settings(list, (message) => sent.push(message));
  const control = {control: 0, label: "New", hint: "", enabled: true, names: [], values: [], missing: [], range: [0, 8], whole: false, logarithmic: false};
  settings.show([{...control, setting: "a", kind: "check", values: ["on", "off"], value: "on"},
                 {...control, setting: "b", kind: "slider", range: [0.1, 1000], logarithmic: true, value: "1"},
                 {...control, setting: "c", kind: "slider", whole: true, value: "3"},
                 {...control, setting: "d", kind: "color", value: "010203"}]);
  const [check, logarithmic, whole, color] = list.querySelectorAll("input");
  check.click();
  for (const [input, value] of [[logarithmic, Math.log(10)], [whole, 7.9], [color, "#0a0b0c"]]) {
    input.value = value;
    input.dispatchEvent(new Event("input"));
  }
  check.dispatchEvent(new Event("change"));
  const values = Object.fromEntries(sent.map((message) => [message.setting, message.value]));
  return [...list.querySelectorAll("input")].map((input, index) => [input.type, values["abcd"[index]]]);
})()"""


def render(page, viewer, at):
    """Shadows, tone mapping and renderer change the images of all viewers, and back. The page is in the front."""
    before = canvas(page)[2]
    # Of all viewers; the choice of images is each viewer's own.
    check(viewer.evaluate("getComputedStyle(document.getElementById('settings')).display") == "none", "a viewer without control has settings")
    check(viewer.evaluate("getComputedStyle(document.getElementById('quality').parentElement).display") != "none", "no choice of images")
    labels = page.evaluate("[...document.querySelectorAll('#settings label')].map((label) => label.firstChild.textContent.trim())")
    check(labels == ["Camera", "Tone mapping", "Shadows", "Renderer"], f"the settings of the page: {labels}")
    values = page.evaluate("[...document.querySelectorAll('#settings select')].map((select) => select.value)")
    check(values == ["none", "neutral", "map", "raster"], f"the settings at the beginning: {values}")
    for control, other, first in (("setting-shadows-0", "c.value = 'off'", "c.value = 'map'"),
                                  ("setting-tone-map-0", "c.value = 'none'", "c.value = 'neutral'")):
        at_viewer, before_viewer = viewer.evaluate("JSON.parse(document.getElementById('canvas').dataset.image).number"), canvas(viewer)[2]
        choose(page, control, other)
        at = image_after(page, at)
        check(psnr_db(before, canvas(page)[2]) < 50, f"{control} changes nothing")
        viewer.call("Page.bringToFront")
        image_after(viewer, at_viewer)
        check(psnr_db(before_viewer, canvas(viewer)[2]) < 50, f"{control} is not that of all viewers")
        page.call("Page.bringToFront")
        choose(page, control, first)
        at = image_after(page, at)
        check(psnr_db(before, canvas(page)[2]) > 60, f"{control} does not come back")
    choose(page, "setting-render-0", "c.value = 'path'")
    page.wait("the samples of a path-traced image", r"/^[1-9]\d* \/ 256 samples$/.test(document.getElementById('samples').textContent)")
    page.wait("shadows of the raster alone", "document.getElementById('setting-shadows-0').disabled")
    choose(page, "setting-render-0", "c.value = 'raster'")
    page.wait("the raster", "document.getElementById('samples').textContent === ''")
    image_after(page, at)
    check(psnr_db(before, canvas(page)[2]) > 60, "the raster does not come back")
    check(page.evaluate(NEW_SETTINGS) == [["checkbox", "off"], ["range", "10"], ["range", "8"], ["color", "0a0b0c"]], "controls of new settings")


def page_at_address(session, page, shown, size):
    """A page at the address of this one, which has the same camera as soon as the renderer has reported it."""
    def same():
        other = session.page(page.evaluate("location.href"), embed=False, size=size)
        image_after(other, 0)
        if psnr_db(shown, canvas(other)[2]) > LEAST_PSNR_DB:
            return other
        other.call("Page.navigate", url="about:blank")
        return None
    return wait_until("a page with the same camera", same)


def link(session, page, name):
    """The address of the page keeps its camera and the selected node; the copied link is one without control."""
    at = page.evaluate("JSON.parse(document.getElementById('canvas').dataset.image).number")
    page.drag((120, 90), (180, 100))
    image_after(page, at)
    shown, size = canvas(page)[2], (640, 300)
    other = page_at_address(session, page, shown, size)
    check(other.evaluate("document.getElementById('picked-name').textContent") == name, "the selected node is lost")
    check(other.evaluate("document.getElementById('rights').textContent") == "", "the link has lost its rights")
    page.evaluate("navigator.clipboard.writeText = async (text) => { window.copied = text; }")
    page.evaluate("document.getElementById('share').click()")
    copied = page.wait("the copied link", "window.copied")
    other = session.page(copied, embed=False, size=size)
    image_after(other, 0)
    check(psnr_db(shown, canvas(other)[2]) > LEAST_PSNR_DB, "the copied link has another camera")
    check(other.evaluate("document.getElementById('picked-name').textContent") == name, "the copied link has no selected node")
    check(other.evaluate("document.getElementById('rights').textContent") == "view only", "the copied link may control")


def viewers(test):
    """The page lists the viewers and their rights, --metrics counts them, and a scene with many cameras has a bounded list of them."""
    own = []  # cameras of the arm's scene

    def add_cameras(document, binary):
        own.extend(node for node in document["nodes"] if "camera" in node)
        document.setdefault("cameras", []).append({"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}})
        first = len(document["nodes"])
        document["nodes"] += [{"name": f"camera {i}", "camera": len(document["cameras"]) - 1, "translation": [0, 0, 2]} for i in range(1200)]
        document["scenes"][0]["nodes"] += range(first, first + 1200)
        return binary
    session = Session(test, "--metrics", "127.0.0.1:0", change=add_cameras)
    rows = "[...document.querySelectorAll('#viewers li')].map((row) => row.innerText.replace(/\\s+/g, ' '))"
    summary = "document.querySelector('#viewers summary').textContent"
    try:
        page = session.page(embed=False, size=(640, 300))
        page.wait("the list of one", f"{summary} === '1 viewer'")
        page.evaluate("document.getElementById('viewers').open = true")
        check(page.evaluate("[...document.querySelectorAll('.viewer.own')].length") == 1, "the page does not find itself")
        viewer = session.page(session.view, embed=False, size=(640, 300))
        for each, index in ((page, 0), (viewer, 1)):
            each.wait("the list of two", f"{summary} === '2 viewers'")
            each.evaluate("document.getElementById('viewers').open = true")
            listed = each.evaluate(rows)
            check(len(listed) == 2 and "control" in listed[0] and "view only" in listed[1], f"{listed}")
            check([row.startswith(f"Viewer {number}") for number, row in enumerate(listed, 1)] == [True, True], f"{listed}")
            check([("(this page)" in row) for row in listed] == [index == 0, index == 1], f"{index}: {listed}")
        url = url_of(session.renderer)

        def count(control, view):
            wait_until(lambda: f"{control} and {view} viewers: {scrape(url).all('fire3dv_viewers')}",
                       lambda: (scrape(url).get("fire3dv_viewers", access="control"), scrape(url).get("fire3dv_viewers", access="view")) == (control, view))
        count(1, 1)
        wait_until("times of encoding", lambda: scrape(url).get("fire3dv_viewer_encode_seconds_count", codec="jpeg") > 0)
        check(scrape(url).get("fire3dv_viewer_image_bytes_total", codec="jpeg") > 1000, "the bytes of images")
        check(page.evaluate("JSON.parse(document.getElementById('canvas').dataset.image).encodeMs") > 0, "the time of encoding an image")
        viewer.call("Page.navigate", url="about:blank")
        page.wait("the list of one", f"{summary} === '1 viewer'")
        count(1, 0)
        options = page.evaluate("[...document.getElementById('cameras').options].map((option) => [option.text, option.disabled])")
        check(len(options) == 1 + 1000 + 1 and options[-1] == [f"{len(own) + 200} further cameras are not listed", True], f"{options[:3]} {options[-2:]}")
        at = image_after(page, 0)
        page.call("Page.bringToFront")
        page.key("2")
        page.wait("the camera", "document.getElementById('cameras').value === '1'")
        image_after(page, at)
        check(not page.errors, f"errors of the page: {page.errors}")
    finally:
        session.end()


def access(test):
    """Wrong tokens, hosts and origins are refused; the log has no token but in the two links."""
    session = Session(test)
    try:
        page = session.page(session.control[:-4] + "0000" if not session.control.endswith("0000") else session.control[:-4] + "1111")
        page.wait("the refusal", "document.getElementById('badge').textContent.includes('not valid')")
        check(page.evaluate("document.getElementById('canvas').dataset.image === undefined"), "an image without a token")
        host, port = session.host.split(":")
        origin = f"http://{session.host}"
        for what, status, options in (("another origin", 403, {"origin": "http://evil.example"}), ("no origin", 403, {}),
                                      ("another host", 421, {"origin": "http://evil.example", "host_header": "evil.example"})):
            client = WebSocketClient(host, int(port), "/socket", **options)
            check(client.status == status, f"{what}: {client.status}")
            client.close()
        client = WebSocketClient(host, int(port), "/socket", origin=origin)
        check(client.status == 101, f"the server's own origin: {client.status}")
        client.send('{"type":"hello","token":"' + "0" * 32 + '"}')
        check(client.close_code() == 4401, "the code of a wrong token")
        for token in (session.control.split("#")[1], session.view.split("#")[1]):
            check(session.renderer.stderr_text().count(token) == 1, "a token is in the log again")
        refused = subprocess.run([test.programs_at["fire3dv"], session.scene, "--headless", "--serve", "0.0.0.0:0"], capture_output=True, text=True,
                                 env=vulkan_environment())
        check(refused.returncode == 1 and "--insecure" in refused.stderr and "--tls-cert" in refused.stderr, refused.stderr)
    finally:
        session.end()


def restart(test):
    """A killed renderer comes back under the same links, and the page connects by itself."""
    tokens = test.path("tokens")
    port = test.fresh_uri("tcp").rsplit(":", 1)[1]
    session = Session(test, "--serve-tokens", tokens, at=f"127.0.0.1:{port}")
    try:
        page, link = session.page(), session.control
        at = image_after(page, 0)
        first = canvas(page)[2]
        page.drag((120, 90), (180, 100))
        image_after(page, at)
        turned = canvas(page)[2]
        check(psnr_db(first, turned) < LEAST_PSNR_DB, "a drag does not move the camera")
        page_at_address(session, page, turned, (WIDTH, HEIGHT)).call("Page.navigate", url="about:blank")
        page.call("Page.bringToFront")
        session.renderer.kill()
        page.wait("the loss", "!document.getElementById('badge').hidden")
        page.evaluate("delete document.getElementById('canvas').dataset.image")
        session.start(f"127.0.0.1:{port}", "--serve-tokens", tokens)
        check(session.control == link, "the links have changed")
        image_after(page, 0)
        check(psnr_db(turned, canvas(page)[2]) > LEAST_PSNR_DB, "the page has lost its camera")
        check(page.evaluate("document.getElementById('badge').hidden"), "the page still says that it is not connected")
        session.renderer.signal(15)
        session.renderer.expect_exit(0)
    finally:
        session.end()


def stream(test):
    """A stream moves the image, and the page has its name and rate."""
    uri = test.fresh_uri("shm")
    session = Session(test, "--listen", uri)
    try:
        page = session.page(embed=False, size=(640, 300))
        number = image_after(page, 0)
        before = canvas(page)[2]
        arm = Program(test, "bullet_arm", [test.programs_at["bullet_arm"], "--to", uri])
        page.wait("the stream", "document.querySelector('#streams .name') !== null")
        image = "JSON.parse(document.getElementById('canvas').dataset.image)"
        page.wait("images of it", f"{image}.number > {number} + 3 && {image}.simTimeS > 0.5")
        check(page.evaluate(f"{image}.codec") == "h264", "moving images are no video")
        page.wait("its rate", "parseFloat(document.querySelector('#streams .number').textContent) > 0")
        arm.signal(signal.SIGSTOP)
        image_after(page, number)  # as refined as the first one
        check(psnr_db(before, canvas(page)[2]) < 60, "the image has not moved")
        arm.kill()
    finally:
        session.end()


PLAY = """(async () => {
  const video = document.createElement("video");
  video.src = "data:video/webm;base64,%s";
  await new Promise((done, fail) => { video.onloadeddata = done; video.onerror = () => fail(video.error); });
  video.muted = true;
  video.playbackRate = 2;
  let frames = 0;
  const count = () => { ++frames; video.requestVideoFrameCallback(count); };
  video.requestVideoFrameCallback(count);
  await video.play();
  await new Promise((done) => { video.onended = done; });
  return [video.videoWidth, video.videoHeight, video.currentTime, frames];
})()"""


def recorded(test, page):
    """A video of the canvas is saved as a file, which plays: its size, its length, and frames that move."""
    folder = test.path("downloads")
    os.makedirs(folder)
    page.downloads_to(folder)
    page.call("Page.bringToFront")
    page.evaluate("document.getElementById('record').click()")
    page.wait("the recording", "document.getElementById('record').getAttribute('aria-pressed') === 'true'")
    for i in range(4):
        page.drag((90 + 5 * i, 90), (120 + 5 * i, 95))
        page.evaluate("new Promise((done) => setTimeout(done, 300))")
    page.evaluate("document.getElementById('record').click()")
    [name] = wait_until("the file", lambda: [name for name in os.listdir(folder) if name.endswith(".webm")])
    with open(os.path.join(folder, name), "rb") as file:
        data = file.read()
    check(name == "arm.glb.webm" and data[:4] == bytes.fromhex("1a45dfa3"), f"{name} is no WebM file")
    player = page.browser.page()
    width, height, seconds, frames = player.evaluate(PLAY % base64.b64encode(data).decode())
    check((width, height) == (WIDTH, HEIGHT) and seconds > 0.8 and frames >= 3, f"{width} x {height}, {seconds} s, {frames} frames")


NO_H264 = """const supported = VideoDecoder.isConfigSupported;
VideoDecoder.isConfigSupported = (config) => config.codec.startsWith("avc") ? Promise.resolve({supported: false}) : supported.call(VideoDecoder, config);"""


def moving(page, at, codec):
    """Moves the camera; the last video image shows the same view as the refined one that follows."""
    page.evaluate("new MutationObserver(() => { if (JSON.parse(canvas.dataset.image).codec === '" + codec + "') window.video = " +
                  PIXELS + "; }).observe(canvas, {attributes: true, attributeFilter: ['data-image']})")
    page.drag((90, 90), (120, 95))
    page.wait("video", "window.video !== undefined")
    image_after(page, at)
    check(page.evaluate("JSON.parse(canvas.dataset.image).codec") == "jpeg", "the refined image is no JPEG")
    still, seen = canvas(page)[2], base64.b64decode(page.evaluate("window.video")[2])
    # Its size follows the machine's speed, so that the PSNR proves the view, and the means prove the colours.
    check(psnr_db(still, seen) > 20, f"the PSNR of {codec} and the refined image is {psnr_db(still, seen):.1f} dB")
    means = [abs(sum(still[c::3]) - sum(seen[c::3])) / (WIDTH * HEIGHT) for c in range(3)]
    check(max(means) < 3, f"{codec}: the means of the colours differ by {means}")
    check(not page.errors, f"errors of the page: {page.errors}")


def video(test):
    """Moving images are H.264 or VP8 with the right colours; a page without WebCodecs gets JPEG; a video is saved."""
    session = Session(test)
    try:
        page = session.page()
        moving(page, image_after(page, 0), "h264")
        other = session.browser.page()
        other.size(WIDTH, HEIGHT)
        other.call("Page.addScriptToEvaluateOnNewDocument", source=NO_H264)
        other.open(session.control.replace("/#", "/?embed=1#"))
        moving(other, image_after(other, 0), "vp8")
        other.call("Page.navigate", url="about:blank")
        recorded(test, page)
        plain = session.browser.page()
        plain.size(WIDTH, HEIGHT)
        plain.call("Page.addScriptToEvaluateOnNewDocument", source="delete window.VideoDecoder; window.seen = []")
        plain.open(session.control.replace("/#", "/?embed=1#"))
        at = image_after(plain, 0)
        plain.evaluate("new MutationObserver(() => window.seen.push(canvas.dataset.image)).observe(canvas, {attributes: true})")
        plain.drag((90, 90), (120, 90))
        image_after(plain, at)
        check(plain.evaluate("window.seen.length > 1 && window.seen.every((image) => JSON.parse(image).codec === 'jpeg')"), "no JPEG without WebCodecs")
    finally:
        session.end()


def replay(test):
    """A replay is paused, stepped and moved by the control link only."""
    uri, recording = test.fresh_uri("shm"), test.path("run.mcap")
    session = Session(test, "--listen", uri, "--record", recording)
    try:
        page = session.page(embed=False, size=(640, 300))
        arm = Program(test, "bullet_arm", [test.programs_at["bullet_arm"], "--to", uri])
        page.wait("frames", "parseInt((document.querySelector('#streams .facts')?.textContent ?? '').split(', ')[1]) > 30")
        arm.kill()
        session.renderer.signal(15)
        session.renderer.expect_exit(0)
        session.start("127.0.0.1:0", "--replay", recording, "--loop")
        page, viewer = session.page(embed=False, size=(640, 300)), session.page(session.view, embed=False, size=(640, 300))
        for each in (page, viewer):
            each.wait("the timeline", "!document.getElementById('timeline').hidden")
        check(viewer.evaluate("document.getElementById('play').disabled"), "a viewer without control may pause")
        playing = "document.getElementById('play-icon').getAttribute('d').startsWith('M4 3h3')"
        seek = "document.getElementById('seek').value"
        page.call("Page.bringToFront")
        page.wait("it to play", playing)
        page.evaluate("document.getElementById('play').click()")
        page.wait("the pause", f"!({playing})")

        def seek_to(fraction):
            page.evaluate(f"(() => {{ const seek = document.getElementById('seek'); seek.value = {fraction}; seek.dispatchEvent(new Event('input')); }})()")
        time = "(JSON.parse(document.getElementById('canvas').dataset.image ?? '{}').simTimeS ?? -1)"  # -1: no image yet
        seek_to(0.6)
        for each in (page, viewer):
            each.wait("the position of all viewers", f"Math.abs({seek} - 0.6) < 0.1")
        # A slow renderer records with gaps: the longest one of the first half is sought, and the frame after it is the next one.
        file = McapFile(recording)
        begin_ns, end_ns = file.messages[0][2], max(message[2] for message in file.messages)
        frames = [(log_ns, pose_frame(data)[2] * 1e-9) for log_ns, data in file.of("poses") if body_of(data)[0] == 2]
        (log_ns, first), (next_log_ns, following) = max(zip(frames[:len(frames) // 2], frames[1:]), key=lambda pair: pair[1][0] - pair[0][0])
        seek_to(((log_ns + next_log_ns) / 2 - begin_ns) / (end_ns - begin_ns))
        page.wait("the frame before the gap", f"Math.abs({time} - {first}) < 1e-6")
        page.evaluate("document.getElementById('step').click()")
        [shown] = page.wait("the next frame", f"Math.abs({time} - {first}) > 1e-6 && [{time}]")
        check(abs(shown - following) < 1e-6, f"a step from {first} s shows {shown} s, not {following} s")
        page.evaluate("document.getElementById('play').click()")
        page.wait("it to play again", playing)
    finally:
        session.end()


def make_certificate(test):
    certificate, key = test.path("certificate.pem"), test.path("key.pem")
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj", "/CN=localhost",
                    "-keyout", key, "-out", certificate], check=True, stderr=subprocess.DEVNULL)
    return certificate, key


def tls(test):
    """With a certificate the page and its WebSocket use TLS."""
    certificate, key = make_certificate(test)
    session = Session(test, "--tls-cert", certificate, "--tls-key", key, browser=("--ignore-certificate-errors",))
    try:
        check(session.control.startswith("https://127.0.0.1:"), session.control)
        page = session.page()
        image_after(page, 0)
        check(len(set(canvas(page)[2])) > 50, "the image is empty")
        check(not page.errors, f"errors of the page: {page.errors}")
    finally:
        session.end()


def proxy(test):
    """Behind a proxy that ends TLS, below a path, the page works for allowed origins; others read why they are refused."""
    front = ReverseProxy(*make_certificate(test))
    allowed, other = (f"https://{name}.example:{front.port}" for name in ("sim", "other"))
    session = Session(test, "--allow-origin", allowed, browser=("--ignore-certificate-errors", "--host-resolver-rules=MAP *.example 127.0.0.1"))
    front.upstream = session.host
    token = session.control.split("#")[1]
    badge = "document.getElementById('badge')?.textContent ?? ''"

    def opened(address):
        page = session.browser.page()
        page.size(WIDTH, HEIGHT)
        page.call("Page.navigate", url=f"{address}?embed=1#{token}")
        return page
    try:
        # A proxy that leaves the path in does not get the page at an address without the last slash.
        for passes_host, strips_path, path in ((False, True, "/sim1"), (True, True, "/sim1/"), (True, False, "/sim1/")):
            front.passes_host, front.strips_path = passes_host, strips_path
            page = opened(allowed + path)
            wait_until("the page's own address", lambda: is_at(page, "/sim1/"))
            image_after(page, 0)
            check(len(set(canvas(page)[2])) > 50, f"the image at {path} is empty")
            check(token in page.evaluate("location.href"), "the token is lost")
            page.call("Page.navigate", url="about:blank")
        front.passes_host, front.strips_path = False, True
        refusal = f"refused by the server: origin {other} is not allowed; start with --allow-origin {other}"
        page = opened(other + "/sim1/")
        wait_until("the page", lambda: is_at(page, "/sim1/"))
        page.wait("the reason", f"({badge}).includes({refusal!r})")
        session.renderer.wait_err(f"warning: --serve: a request was refused: origin {other} is not allowed")
        page.call("Page.navigate", url="about:blank")
        front.passes_upgrade = False
        page = opened(allowed + "/sim1/")
        wait_until("the page", lambda: is_at(page, "/sim1/"))
        page.wait("the reason", f"({badge}).includes('the proxy must pass Upgrade and Connection on')")
        page.call("Page.navigate", url="about:blank")
    finally:
        session.end()
        front.close()


def is_at(page, path):
    try:
        return page.evaluate("location.pathname") == path
    except Failure:  # while the page goes to another address
        return False


if __name__ == "__main__":
    main({"image": image, "cameras": cameras, "touch": touch, "nodes": nodes, "viewers": viewers, "access": access, "restart": restart,
          "stream": stream, "video": video, "replay": replay, "tls": tls, "proxy": proxy}, ["fire3dv", "bullet_arm"])
