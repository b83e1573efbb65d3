#!/usr/bin/env python3
"""End-to-end test of the live view's panels in headless Chromium: plots of scalars, and joints."""
import csv
import json
import math
import os
import time

import fire3dv
from glb_edit import edit_glb
from harness import main, wait_until
from image_reader import check, write_scene
from live_session import Session, canvas, image_after, psnr_db

SIZE = (760, 480)  # above the width at which the panel is closed
STEPS, STEP_NS = 200, 10_000_000
START_NS = 1_700_000_000_000_000_001  # more digits than a number of JavaScript has
IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]

PLOT = """(() => {
  const canvas = document.getElementById("plot");
  const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  const found = {curve: {}, line: {}};
  for (let x = 0; x < canvas.width; ++x) {
    for (let y = 0; y < canvas.height; ++y) {
      const i = 4 * (y * canvas.width + x), [r, g, b] = [data[i], data[i + 1], data[i + 2]];
      if (b > r + 80) (found.curve[x] ??= []).push(y);
      if (r > b + 60) found.line[x] = (found.line[x] ?? 0) + 1;
    }
  }
  return [canvas.width, canvas.height, found];
})()"""


def plots(test):
    """A chosen scalar is drawn where its values are, with a line at the shown time; the file has every digit; a view link may look."""
    scene, uri, folder = test.path("red.glb"), test.fresh_uri("shm"), test.path("downloads")
    write_scene(scene, {"red": ((1, 0, 0), 0)}, place=0)
    os.makedirs(folder)
    session = Session(test, "--listen", uri, scene=scene)
    times = [START_NS + step * STEP_NS for step in range(STEPS + 1)]
    values = [math.sin(2 * math.pi * step / STEPS) for step in range(STEPS + 1)]
    try:
        page = session.page(session.view, embed=False, size=SIZE, scheme="dark")
        page.downloads_to(folder)
        check(page.evaluate("document.getElementById('plots').hidden"), "there are plots without scalars")
        with fire3dv.Stream(uri, adapter_name="pendulum") as stream:
            stream.describe(["red"])
            for time_ns, value in zip(times, values):
                stream.scalars("joints", time_ns, {"hinge": value, "speed": 0.1 * value}, units={"hinge": "rad"})
                time.sleep(0.001)  # the link keeps all of them
                if time_ns == times[STEPS // 2]:
                    stream.publish(time_ns, [IDENTITY])
            page.wait("the plots", "!document.getElementById('plots').hidden")
            page.evaluate("document.querySelector('#plots summary').focus()")
            page.key(" ")  # opens the section, and plays no replay
            page.wait("the open section", "document.getElementById('plots').open")
            listed = "[...document.querySelectorAll('#scalars label')].map((label) => label.innerText.replace(/\\s+/g, ' ').trim())"
            page.wait("the scalars", f"JSON.stringify({listed}) === {json.dumps(json.dumps(['joints/hinge rad', 'joints/speed'], separators=(',', ':')))}")
            page.evaluate("document.querySelector('#scalars input').click()")
            newest = "document.querySelector('#scalars output').textContent"
            page.wait("the newest value", f"/ rad$/.test({newest}) && Math.abs(parseFloat({newest})) < 1e-9")
            drawn(page, values)
            table(page, folder, times, values)
            cursor(page)
            page.wait("the pause", "document.getElementById('plot-pause').getAttribute('aria-pressed') === 'true'")
            stream.scalars("joints", times[-1] + STEP_NS, {"hinge": 0.5, "speed": 0})
            page.wait("a later value", f"parseFloat({newest}) === 0.5")
            check(page.evaluate("document.getElementById('plot-pause').getAttribute('aria-pressed')") == "true", "a new value ends the pause")
        page.wait("the end of the stream", "document.querySelectorAll('#scalars label').length === 0")
        check(not page.errors, f"errors of the page: {page.errors}")
    finally:
        session.end()


def drawn(page, values):
    """The curve's pixels are where the values are: 1.2 times as high as their range; the line is in the middle of the time."""
    def columns():
        width, height, found = page.evaluate(PLOT)
        tall = [int(x) for x, count in found["line"].items() if count > height / 2]
        return len(found["curve"]) > width * 0.8 and tall and (width, height, found["curve"], tall)
    width, height, curve, line = wait_until("the curve", columns)
    for x, ys in curve.items():
        value = values[round(int(x) / width * STEPS)]
        expected = height * (1.2 - value) / 2.4
        check(min(abs(y - expected) for y in ys) < 0.05 * height, f"at {x} the curve is at {ys}, not at {expected:.0f} of {height}")
    check(all(abs(x - width / 2) <= 2 for x in line), f"the line at the shown time is at {line} of {width}")


def table(page, folder, times, values):
    page.evaluate("document.getElementById('plot-csv').click()")
    path = os.path.join(folder, "red.glb scalars.csv")
    wait_until("the file", lambda: os.path.exists(path))
    with open(path, encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    check(head == ["sim_time_s", "joints/hinge [rad]"], f"{head}")
    check(len(rows) == len(times), f"{len(rows)} rows")
    for (second, text), time_ns, value in zip(rows, times, values):
        check(second == f"{time_ns // 10**9}.{time_ns % 10**9:09}" and float(text) == value, f"{second}, {text}: not {time_ns}, {value}")


def cursor(page):
    """The cursor has the value under it, and the wheel zooms about it."""
    left, top, width, height = page.evaluate("(() => { const b = document.getElementById('plot').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()")
    x, y = left + width / 4, top + height / 2
    value = "parseFloat(document.querySelector('#scalars output').textContent)"
    page.mouse("mouseMoved", x, y)
    page.wait("the value at the cursor", f"Math.abs({value} - 1) < 0.01")
    page.mouse("mouseWheel", x, y, deltaX=0, deltaY=-500)
    page.wait("the zoom", "!document.getElementById('plot-all').disabled")
    page.mouse("mouseMoved", x + width / 4, y)
    share = 0.25 + 0.25 * 0.8 ** 5  # of the whole time
    page.wait("the value at the cursor", f"Math.abs({value} - {math.sin(2 * math.pi * share)}) < 0.05")
    page.mouse("mouseMoved", left + width / 2, top - 20)


ROBOT = {"version": 1, "bodies": [{"node": "red"}],
         "joints": [{"name": "lift", "type": "prismatic", "node": "red", "axis": [0, 1, 0], "limits": [-20, 30]}],
         "poses": [{"name": "high", "positions": [25]}]}


def red_row(page):
    """Mean row of the red pixels."""
    width, _, data = canvas(page)
    rows = [i // width for i in range(len(data) // 3) if data[3 * i] > 100 and data[3 * i + 1] < 100]
    check(rows, "nothing is red")
    return sum(rows) / len(rows)


def joints(test):
    """Joints move by sliders and named poses of the control link only, and not while a stream drives them."""
    scene, uri = test.path("red.glb"), test.fresh_uri("shm")

    def add_robot(document, binary):
        [node] = [node for node in document["nodes"] if node.get("name") == "red"]
        node.setdefault("extras", {})["fire3dv"] = {"robot": ROBOT}
        return binary
    write_scene(scene, {"red": ((1, 0, 0), 0)}, place=0)
    edit_glb(scene, scene, add_robot)
    session = Session(test, "--listen", uri, scene=scene)
    value = "document.querySelector('#joint-list output')?.textContent"
    try:
        page = session.page(embed=False, size=SIZE)
        at = image_after(page, 0)
        first, home = canvas(page)[2], red_row(page)
        page.wait("the joint", "!document.getElementById('joints').hidden")
        page.evaluate("document.getElementById('joints').open = true")
        page.wait("its position", f"{value} === '0.000 m'")

        def slide(position):
            page.evaluate(f"(() => {{ const s = document.querySelector('#joint-list input'); s.value = {position}; s.dispatchEvent(new Event('input')); }})()")
        page.evaluate("[...document.querySelectorAll('#tree .label')].find((label) => label.textContent === 'red').click()")
        position = "document.getElementById('picked-position').textContent"
        page.wait("the position of the selected node", f"{position} === '0.000, 0.000, 0.000 m'")
        slide(25)
        page.wait("the node to move", f"{position} === '0.000, 25.000, 0.000 m'")
        at = image_after(page, at)
        high = red_row(page)
        check(high < home - 5, f"the square is at {high}, was at {home}")
        viewer = session.page(session.view, embed=False, size=SIZE)
        image_after(viewer, 0)
        check(abs(red_row(viewer) - high) < 1, "the joint is not moved for the other viewer")
        viewer.wait("the position", f"{value} === '25.000 m'")
        check(viewer.evaluate("document.querySelector('#joint-list input').disabled && document.getElementById('posture').disabled"),
              "a view link may move joints")
        denied(session)
        page.call("Page.bringToFront")
        page.wait("the pose of this position", "document.getElementById('posture').value === '0'")
        slide(1000)  # beyond the limit
        page.wait("the limit", f"{value} === '30.000 m' && document.getElementById('posture').value === 'hand'")
        at = image_after(page, at)
        choose = "(() => {{ const p = document.getElementById('posture'); p.value = '{}'; p.dispatchEvent(new Event('change')); }})()"
        page.evaluate(choose.format(0))
        page.wait("the named pose", f"{value} === '25.000 m'")
        at = image_after(page, at)
        check(abs(red_row(page) - high) < 1, "the named pose is another one")
        page.evaluate(choose.format("file"))
        page.wait("the pose of the file", f"{value} === '0.000 m'")
        at = image_after(page, at)
        check(psnr_db(first, canvas(page)[2]) > 60, "the pose of the file does not come back")
        with fire3dv.Stream(uri, adapter_name="driver") as stream:
            stream.describe(["red"])
            stream.publish(1, [IDENTITY])
            page.wait("the driver", f"{value} === 'by driver' && document.querySelector('#joint-list input').disabled")
        check(not page.errors and not viewer.errors, f"errors of the page: {page.errors} {viewer.errors}")
    finally:
        session.end()


def denied(session):
    """A message of a view link does not move a joint."""
    client = session.viewer(*SIZE, link=session.view)
    number = None
    while number is None:
        kind, payload = client.receive()
        message = json.loads(payload) if kind == 1 else {}
        number = message.get("scene") if message.get("type") == "joints" else None
    client.send(json.dumps({"type": "joint", "scene": number, "index": 0, "position": -10}))
    client.send('{"type":"pick","x":0.5,"y":0.5}')  # its answer comes after the effect of the message before
    while True:
        kind, payload = client.receive()
        if kind == 1 and json.loads(payload)["type"] == "picked":
            break
    client.close()
    check(session.browser.process.poll() is None, "the browser has ended")


def raised(height):
    return [[1, 0, 0, 0, 0, 1, 0, height, 0, 0, 1, 0]]


class Tuning:
    """A simulation in this process, whose controls a page uses."""

    def __init__(self, stream):
        self.stream, self.time_ns, self.log = stream, 0, []
        controls = stream.controls
        self.height = controls.slider("square/height", 0, 20, unit="m")
        self.mode = controls.choice("square/mode", ["hold", "track"])
        self.glow = controls.toggle("glow")
        self.kick = controls.button("kick", on_press=lambda: self.log.append("kick"))
        self.note = controls.text("note", "empty", on_change=self.log.append)
        self.run = controls.run(running=False, speeds=(0.5, 2))

    def until(self, what, condition):
        """Steps until something has happened."""
        def step():
            self.stream.events()
            self.time_ns += 1_000_000
            self.stream.publish(self.time_ns, raised(self.height.value))
            return condition()
        return wait_until(what, step)


def controls(test):
    """Controls that a Python program declares act on it from a page with control, and from no other."""
    scene, uri = test.path("red.glb"), test.fresh_uri("shm")
    write_scene(scene, {"red": ((1, 0, 0), 0)}, place=0)
    session = Session(test, "--listen", uri, scene=scene)
    try:
        page = session.page(embed=False, size=SIZE)
        at = image_after(page, 0)
        home = red_row(page)
        check(page.evaluate("document.getElementById('controls').hidden"), "there are controls without a stream")
        with fire3dv.Stream(uri, adapter_name="tuning") as stream:
            stream.describe(["red"])
            tuning = Tuning(stream)
            tuning.until("the renderer", lambda: stream.poll().acked_sequence > 0)
            page.wait("the controls", "document.querySelectorAll('#control-list input[type=range]').length === 2")
            names = page.evaluate("[...document.querySelectorAll('#control-list li')].map((item) => item.innerText.replace(/\\s+/g, ' ').trim())")
            check([name.split(" ")[0] for name in names] == ["glow", "kick", "note", "Run", "square", "height", "mode"], f"{names}")
            slide(page, tuning, at, home)
            others(page, tuning)
            run_bar(page, tuning)
            shared(session, page, tuning)
            view_only(session, tuning)
        page.wait("the end of the stream", "document.getElementById('controls').hidden")
        check(not page.errors, f"errors of the page: {page.errors}")
    finally:
        session.end()


def slide(page, tuning, at, home):
    """A click on the slider's track, and an arrow key: real input events."""
    x, y, width, height = page.evaluate("(() => { const s = document.querySelector('#control-list [aria-label=height]'); s.scrollIntoView(); "
                                        "const b = s.getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()")
    page.click(x + width / 2, y + height / 2)
    tuning.until("the slider's value", lambda: abs(tuning.height.value - 10) < 1)
    before = tuning.height.value
    page.key("ArrowRight")
    tuning.until("the next value", lambda: abs(tuning.height.value - before - 0.1) < 1e-9)
    image_after(page, at)
    wait_until("the square to be higher", lambda: red_row(page) < home - 5)
    page.evaluate("(() => { const n = document.querySelector('#control-list [type=number]:not([aria-label^=Speed])'); n.value = 1000; n.dispatchEvent(new Event('change')); })()")
    tuning.until("the limit", lambda: tuning.height.value == 20)


def others(page, tuning):
    def use(selector, change):
        page.evaluate(f"(() => {{ const e = document.querySelector('#control-list {selector}'); {change}; }})()")
    use("li:nth-child(1) input", "e.click()")
    use("li:nth-child(2) button", "e.click()")
    use("select", "e.value = '1'; e.dispatchEvent(new Event('change'))")
    use("[type=text]", "e.value = 'Körper <b>'; e.dispatchEvent(new Event('change'))")
    tuning.until("all of them", lambda: tuning.glow.value and tuning.mode.value == "track" and tuning.kick.presses == 1
                 and tuning.note.value == "Körper <b>")
    check(tuning.log == ["kick", "Körper <b>"], f"callbacks: {tuning.log}")


def run_bar(page, tuning):
    press = "[...document.querySelectorAll('#control-list .run button')].find((button) => button.textContent === '{}').click()"
    page.evaluate(press.format("Step"))
    page.evaluate(press.format("Step"))
    steps = []
    tuning.until("two steps", lambda: steps.append(tuning.run.take_steps()) or sum(steps) == 2)
    page.evaluate(press.format("Reset"))  # ends steps that nobody has taken
    tuning.until("the reset", tuning.run.take_reset)
    page.evaluate(press.format("Run"))
    tuning.until("the run", lambda: tuning.run.running)
    page.wait("the button to pause", "document.querySelector('#control-list .run button').textContent === 'Pause'")
    page.evaluate("(() => { const s = document.querySelector('#control-list .run [type=range]'); s.value = 1.5; s.dispatchEvent(new Event('input')); })()")
    tuning.until("the speed", lambda: abs(tuning.run.speed - 1.5) < 0.01)


def shared(session, page, tuning):
    """The program's value is that of all pages, also of those that come later; a set value reaches them."""
    second = session.page(embed=False, size=SIZE)
    value = "document.querySelector('#control-list [aria-label=height]')?.value"
    second.wait("the slider of another page", f"{value} === '20'")
    second.call("Page.close")
    page.call("Page.bringToFront")
    tuning.height.value = 5
    page.wait("the value that the program set", f"{value} === '5'")


def view_only(session, tuning):
    """A view link lists no controls, and no message of it acts."""
    viewer = session.page(session.view, embed=False, size=SIZE)
    viewer.wait("the stream", "document.querySelectorAll('.stream').length === 1")
    check(viewer.evaluate("document.getElementById('controls').hidden"), "a view link has controls")
    client = session.viewer(*SIZE, link=session.view)
    for number in range(4):
        for index in range(6):
            for action in ("set", "press", "run", "pause", "step", "reset", "speed"):
                client.send(json.dumps({"type": "input", "list": number, "index": index, "action": action, "value": 1, "text": "x"}))
    client.send('{"type":"pick","x":0.5,"y":0.5}')  # its answer comes after the effect of the messages before
    while True:
        kind, payload = client.receive()
        check(kind != 1 or json.loads(payload)["type"] != "inputs", "a view link gets the list of inputs")
        if kind == 1 and json.loads(payload)["type"] == "picked":
            break
    client.close()
    tuning.height.value = 6
    found = []
    tuning.until("another frame", lambda: found.extend(tuning.stream.events()) or tuning.stream.poll().acked_sequence > tuning.stream.sequence - 3)
    check(not found and tuning.height.value == 6 and tuning.kick.presses == 1, f"a view link acts: {found}")


if __name__ == "__main__":
    main({"plots": plots, "joints": joints, "controls": controls}, ["fire3dv"])
