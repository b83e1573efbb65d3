#!/usr/bin/env python3
"""End-to-end test of the whole window at a display scale of 2 with real X input: guides, measuring, namespaces of markers,
joints and their poses, editing, plots, screenshots, the theme and recent files, in one window of 1280x720 pixels.
"""
import json
import math
import os

import fire3dv
from glb_edit import edit_glb
from harness import main, wait_until
from image_reader import SQUARES, Picture, check, ranges_about, read_png, write_scene
from screen import on_a_screen

WINDOW = (1280, 720)
IMAGE = (384, 0, 896, 614)  # left, top, right and bottom of the image between closed panels
UNIT_PX = IMAGE[3] / 90  # the camera shows 90 units of height
MEASURE_COLOUR, ACCENT, PANEL, LIGHT_PANEL = (255, 192, 64), (0x4a, 0xa3, 0xdf), (0x17, 0x19, 0x1d), (0xf4, 0xf5, 0xf7)
MARKERS = {"left": ((255, 0, 255), -25), "right": ((0, 255, 255), 25)}  # colour, place along x
PANELS = ("scene", "node", "edit", "joints", "measure", "cameras", "frame", "streams", "render", "lights", "materials", "plots", "log")
# Headers while all panels are closed, and controls while only their panel is open.
HEADERS = {"scene": (120, 47), "joints": (120, 227), "streams": (1000, 107), "render": (1000, 167), "plots": (1000, 347)}
CHECK_OF_LEFT, LIFT, LIFTED, POSE, POSE_HIGH = (1222, 427), (162, 367), (370, 367), (230, 321), (230, 405)
SIZE_CHOICE, SIZE_TWICE, THEME, FILES, SECOND_FILE = (1140, 261), (1140, 343), (1220, 571), (230, 93), (230, 185)
PLOT, FIRST_SCALAR = ((932, 244), (1238, 580)), (1000, 683)  # after scrolling to the end of the column
BELOW_PLOT = (1225, 640)  # in the plot before that


def write_robot(path):
    """Three squares in the middle, and a second camera; a joint lifts the red square by 10 units at most."""
    robot = {"version": 1, "bodies": [{"node": "red"}],
             "joints": [{"name": "lift", "type": "prismatic", "node": "red", "axis": [0, 1, 0], "limits": [0, 10]}],
             "poses": [{"name": "high", "positions": [8]}]}

    def add_robot(document, binary):
        nodes = document["nodes"]
        red = next(i for i, node in enumerate(nodes) if node["name"] == "red")
        nodes.append({"name": "robot", "children": [red], "extras": {"fire3dv": {"robot": robot}}})
        nodes.append({"name": "side", "camera": 1, "translation": [20, 0, 0], "rotation": [0, 0.5**0.5, 0, 0.5**0.5]})
        document["cameras"].append({"type": "perspective", "perspective": {"yfov": 0.6, "znear": 1, "zfar": 20}})
        document["scenes"][0]["nodes"] = [i for i in range(len(nodes)) if i != red]
        return binary
    write_scene(path, place=0)
    edit_glb(path, path, add_robot)


class Window:
    def __init__(self, screen, program):
        self.screen, self.window = screen, screen.window(program)

    def picture(self):
        return self.screen.picture(self.window)

    def image(self):
        """Rows of the image between the panels."""
        left, top, right, bottom = IMAGE
        return [row[3 * left:3 * right] for row in self.picture().rows[top:bottom]]

    def key(self, *names):
        for name in names:
            self.screen.key(name)

    def click(self, at, button=1):
        self.screen.click(self.window, *at, button=button)

    def toggle(self, panel):
        """Opens or closes a panel, and waits until what is below its title has changed."""
        x, y = HEADERS[panel]

        def below():
            return [row[3 * (x - 100):3 * (x + 100)] for row in self.picture().rows[y + 30:y + 50]]
        before = below()
        self.click((x, y))
        wait_until(f"the panel {panel} to change", lambda: below() != before)

    def choose(self, choice, item):
        """Opens a choice, waits for its list, and clicks an item."""
        x, y = item

        def row():
            return self.picture().rows[y][3 * (x - 60):3 * (x + 60)]
        before = row()
        self.click(choice)
        wait_until("a list", lambda: row() != before)
        self.click(item)

    def drag(self, begin, end):
        self.screen.move(self.window, *begin)
        self.screen.press_here()
        for step in range(1, 6):
            self.screen.move(self.window, *(b + (e - b) * step // 5 for b, e in zip(begin, end)))
        self.screen.release()

    def square(self, name):
        """Centre of a square in units from the centre of the image, y up, or None."""
        left, top, right, bottom = IMAGE
        image = Picture(right - left, bottom - top, self.image())
        box = image.box_of(ranges_about([255 * c for c in SQUARES[name][0]], 1))  # unlit
        return box and ((box[0] + box[2] - image.width) / 2 / UNIT_PX, (image.height - box[1] - box[3] + 1) / 2 / UNIT_PX)

    def wait_square(self, name, x, y):
        def is_there():
            now = self.square(name)
            return now and abs(now[0] - x) < 0.5 and abs(now[1] - y) < 0.5
        wait_until(lambda: f"{name} at {x} {y}, not {self.square(name)}", is_there)

    def markers(self):
        row = self.image()[round(IMAGE[3] / 2 + 30 * UNIT_PX)]
        pixels = set(zip(*[iter(row)] * 3))
        return {name for name, (colour, _) in MARKERS.items() if colour in pixels}


def guides_and_measure(window, program):
    at_rest = window.image()
    for key in ("x", "k"):
        window.key(key)
        wait_until(f"what {key} shows", lambda: window.image() != at_rest)
        window.key(key)
        wait_until("what was there at first", lambda: window.image() == at_rest)
    window.key("m")
    for name in ("red", "blue"):
        x, y = 640, round(IMAGE[3] / 2 - SQUARES[name][1] * UNIT_PX)
        window.click((x, y))
        wait_until(f"a mark on {name}", lambda at=(x, y): window.picture().pixel(*at) == MEASURE_COLOUR)
    length = float(program.wait_err(r"distance (\S+) m from").group(1))
    check(abs(length - 40) < 0.3, f"measured {length}")
    window.key("Escape")
    wait_until("what was there at first", lambda: window.image() == at_rest)


def markers(window, stream):
    window.toggle("streams")
    for shown in ({"right"}, {"left", "right"}):
        window.click(CHECK_OF_LEFT)
        wait_until(f"markers {shown}", lambda s=shown: stream.poll() and window.markers() == s)
    window.toggle("streams")


def joints(window):
    window.toggle("joints")
    window.drag(LIFT, LIFTED)
    wait_until("red at its limit", lambda: abs((window.square("red") or (0, 0))[1] - 40) < 0.5)
    window.choose(POSE, POSE_HIGH)
    window.wait_square("red", 0, 38)
    window.toggle("joints")


def editing(window, program, overlay):
    plain = window.image()
    window.click((640, round(IMAGE[3] / 2 - SQUARES["blue"][1] * UNIT_PX)))
    wait_until("an outline", lambda: window.image() != plain)
    outlined = window.image()
    window.key("g")
    wait_until("the gizmo", lambda: window.image() != outlined)
    origin = 640, IMAGE[3] // 2
    window.drag(origin, (origin[0] + 110, origin[1] + 60))
    moved = 110 / UNIT_PX, -10 - 60 / UNIT_PX
    window.wait_square("blue", *moved)
    window.key("ctrl+z")
    window.wait_square("blue", 0, -10)
    window.key("ctrl+y")
    window.wait_square("blue", *moved)
    window.key("ctrl+s")
    program.wait_err(r"2 edits saved to ")
    with open(overlay, encoding="utf-8") as file:
        edits = json.load(file)["fire3dv_overlay"]["edits"]
    check({key for edit in edits for key in ("node", "joint") if key in edit} == {"node", "joint"}, f"{edits}")
    window.key("Escape", "Escape")


def plots(window):
    window.toggle("plots")
    (left, top), (right, bottom) = PLOT

    def has_curve():
        rows = window.picture().matches(ranges_about(ACCENT, 24), left, right)[top:bottom]
        return sum(map(any, zip(*rows))) > (right - left) // 2
    for _ in range(4):
        window.click((1100, 107), button=5)
    wait_until("the end of the column", lambda: window.picture().pixel(*BELOW_PLOT) == PANEL)
    window.click(FIRST_SCALAR)
    wait_until("a curve", has_curve)
    for _ in range(4):
        window.click((1100, 33), button=4)
    wait_until("its begin", lambda: window.picture().pixel(*BELOW_PLOT) != PANEL)
    window.toggle("plots")


def screenshot_and_theme(window, program):
    window.toggle("render")

    def chosen():
        x, y = SIZE_CHOICE
        return [row[3 * (x - 80):3 * (x + 50)] for row in window.picture().rows[y - 10:y + 10]]
    before = chosen()
    window.choose(SIZE_CHOICE, SIZE_TWICE)
    window.screen.move(window.window, 640, 700)
    wait_until("another size", lambda: chosen() != before)
    window.key("p")
    taken = read_png(program.wait_err(r"screenshot (.*\.png)").group(1))
    check((taken.width, taken.height) == (2 * (IMAGE[2] - IMAGE[0]), 2 * IMAGE[3]), f"{taken.width}x{taken.height}")
    check(all(taken.row_of(name) for name in SQUARES), "squares are missing")
    window.click(THEME)
    wait_until("light panels", lambda: window.picture().pixel(30, 700) == LIGHT_PANEL)
    window.toggle("render")


def everything(test, screen):
    scene, other, uri = test.path("robot.glb"), test.path("red.glb"), test.fresh_uri("shm")
    write_robot(scene)
    write_scene(other, {"green": SQUARES["green"]}, place=0)
    layout = test.path("config/fire3dv/window.conf")
    for path, lines in ((layout, [f"{panel} = closed" for panel in PANELS] + ["scalars-seen = yes"]), (test.path("state/fire3dv/recent"), [other])):
        os.makedirs(os.path.dirname(path))
        with open(path, "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
    program = test.viewer(scene, "--listen", uri, "--camera", "front", "--samples", "1", "--shadows", "off", "--background", "204080",
                          "--screenshots", test.path("taken"), env=screen.env, size=WINDOW)
    window = Window(screen, program)
    window.wait_square("red", 0, 30)
    with fire3dv.Stream(uri, adapter_name="simulator") as stream:
        stream.describe([])
        for name, (colour, x) in MARKERS.items():
            stream.points(f"{name}/point", [[x, -30, 0]], colors=tuple(c / 255 for c in colour), size_px=16, overlaid=True)
        for step in range(200):
            stream.scalars("joints", step * 10_000_000, {"hinge": math.sin(step / 30)})
        stream.publish(2_000_000_000, [])
        wait_until("both markers", lambda: stream.poll() and window.markers() == set(MARKERS))
        guides_and_measure(window, program)
        markers(window, stream)
        joints(window)
        editing(window, program, scene + ".overlay.json")
        plots(window)
        screenshot_and_theme(window, program)
    window.toggle("scene")
    window.choose(FILES, SECOND_FILE)
    wait_until("the other scene", lambda: window.square("red") is None and window.square("green"))
    screen.x11.close(window.window)
    program.expect_exit(0)
    with open(layout, encoding="ascii") as file:
        check("theme = light" in file.read(), "the theme is not stored")


if __name__ == "__main__":
    main({"everything": on_a_screen(everything, size=(1280, 800), dpi=192)}, ["fire3dv"])
