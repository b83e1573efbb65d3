#!/usr/bin/env python3
"""End-to-end test of the viewer window with real X input: selection, hiding, screenshots, windows per camera, dropped
files, and closing during a load.
"""
import glob
import json
import os
import re
import shlex
import struct
import sys
import time

from harness import HANG_S, Program, check_tags, main, wait_until
from image_reader import check, read_png, write_scene
from screen import SIZE, all_squares, on_a_screen

TOUR = os.path.join(os.path.dirname(__file__), "..", "..", "..", "docs", "tour.md")

# Rest positions of the squares in pixels of a window of SIZE.
AT = {"red": (292, 30), "green": (292, 70), "blue": (292, 110)}


MEASURE_COLOUR = (255, 192, 64)  # of points and their distance; markers are shown as they are


def seen(picture):
    return {name for name in AT if picture.place_of_square(name) is not None}


def seen_anywhere(picture):
    return {name for name in AT if picture.row_of(name) is not None}


def open_viewer(test, screen, *arguments, **options):
    renderer = test.renderer(*arguments, headless=False, size=SIZE, env=screen.env, **options)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    return renderer, window


def selects(test, screen):
    """A click selects a body, keys hide and isolate it; Escape clears the selection and never closes the window, Ctrl+Q does."""
    renderer, window = open_viewer(test, screen)
    at_rest = screen.picture(window).rows

    def click(x, y):
        screen.click(window, x, y)

    def shows(names):
        wait_until(lambda: f"{names} on the screen, not {seen(screen.picture(window))}",
                   lambda: seen(screen.picture(window)) == set(names))

    click(*AT["green"])
    wait_until("an outline", lambda: screen.picture(window).rows != at_rest)
    outlined = screen.picture(window)
    check(seen(outlined) == set(AT), f"selecting changed what is seen: {seen(outlined)}")
    changed = {y for y in range(SIZE[1]) if outlined.rows[y] != at_rest[y]}
    check(changed and all(abs(y - AT["green"][1]) < 16 for y in changed), f"the outline is in rows {sorted(changed)}")
    screen.key("h")
    shows({"red", "blue"})
    screen.key("h")
    shows(AT)
    screen.key("i")
    shows({"green"})
    screen.key("shift+h")
    shows(AT)
    click(*AT["red"])
    wait_until("the other to be outlined", lambda: screen.picture(window).rows[AT["green"][1] - 12:] == at_rest[AT["green"][1] - 12:])
    screen.key("h")
    shows({"green", "blue"})
    screen.key("h", "f")
    wait_until("red in the middle", lambda: abs((screen.picture(window).row_of("red") or 0) - SIZE[1] / 2) < 3)
    screen.key("1", "Escape")
    wait_until("what was there at first", lambda: screen.picture(window).rows == at_rest)
    click(*AT["blue"])
    wait_until("an outline again", lambda: screen.picture(window).rows != at_rest)
    click(100, 90)  # background
    wait_until("no outline", lambda: screen.picture(window).rows == at_rest)
    screen.key("Escape", "Escape")
    time.sleep(0.5)  # several images
    check(renderer.alive(), "Escape closed the window")
    screen.key("ctrl+q")
    renderer.expect_exit(0)


def measures(test, screen):
    """M and two clicks measure a distance, which is drawn and logged; Escape ends it and removes what was drawn."""
    renderer = test.viewer(test.scene, "--gui", "off", "--camera", "front", env=screen.env, size=SIZE)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    at_rest = screen.picture(window).rows
    screen.key("m")
    for name in ("red", "blue"):
        screen.click(window, *AT[name])
        wait_until(f"a mark on {name}", lambda n=name: screen.picture(window).pixel(*AT[n]) == MEASURE_COLOUR)
    words = renderer.wait_err(r"distance (\S+) m from (\S+) (\S+) \S+ to (\S+) (\S+) \S+; along x y z: (\S+) (\S+) \S+").groups()
    length, *rest = (float(word) for word in words)
    expected = (AT["blue"][1] - AT["red"][1]) / 2  # two pixels a unit
    check(abs(length - expected) < 0.5 and abs(rest[5] + expected) < 0.5 and abs(rest[4]) < 0.5, f"measured {words}")
    x, y = (AT["red"][0] + 0.5 - SIZE[0] / 2) / 2, (SIZE[1] / 2 - AT["red"][1] - 0.5) / 2
    check(abs(rest[0] - x) < 0.5 and abs(rest[1] - y) < 0.5,
          f"the first point is at {words}")
    middle = (AT["red"][0], (AT["red"][1] + AT["blue"][1]) // 2 - 12)
    wait_until("the line", lambda: screen.picture(window).pixel(*middle) == MEASURE_COLOUR)
    screen.key("Escape")
    wait_until("what was there at first", lambda: screen.picture(window).rows == at_rest)
    check(renderer.alive(), "Escape closed the window instead")
    screen.key("ctrl+q")
    renderer.expect_exit(0)


def focuses(test, screen):
    """Shift F puts the plane in focus through the clicked surface."""
    def open_window(*arguments):
        renderer = test.viewer(test.scene, "--gui", "off", "--camera", "auto", *arguments, env=screen.env, size=SIZE)
        return renderer, screen.window(renderer)

    renderer, window = open_window()
    wait_until("all squares on the screen", lambda: len(seen_anywhere(screen.picture(window))) == 3)
    sharp = screen.picture(window)
    y = int(sharp.row_of("green"))
    x = next(x for x in range(SIZE[0]) if sharp.pixel(x, y)[1] > 200 > sharp.pixel(x, y)[0])
    screen.x11.close(window)
    renderer.expect_exit(0)

    renderer, window = open_window("--f-number", "0.15", "--focus-distance", "1")  # a wider blur takes seconds on a CPU
    wait_until("a blurred image", lambda: len({bytes(row) for row in screen.picture(window).rows}) > 20)
    check(not seen_anywhere(screen.picture(window)), "squares out of focus are sharp")
    blurred = screen.picture(window).rows
    screen.click(window, x + 4, y)
    wait_until("an outline", lambda: screen.picture(window).rows != blurred)
    screen.key("shift+f")
    wait_until("the squares in focus", lambda: len(seen_anywhere(screen.picture(window))) == 3)
    screen.key("ctrl+q")
    renderer.expect_exit(0)


def guides(test, screen):
    """G shows and hides the grid, C the frusta of the cameras; the images of --out have neither."""
    for writes in (False, True):
        if writes:
            renderer, window = open_viewer(test, screen)
        else:
            renderer = test.viewer(test.scene, "--gui", "off", "--camera", "auto", env=screen.env, size=SIZE)
            window = screen.window(renderer)
            wait_until("all squares on the screen", lambda: len(seen_anywhere(screen.picture(window))) == 3)
        at_rest = screen.picture(window).rows

        def changed_rows(before=at_rest):
            return sum(row != other for row, other in zip(screen.picture(window).rows, before))
        for key, rows in (("x", 60), ("k", 10)):
            screen.key(key)
            if writes:
                at = len(renderer.frames())
                wait_until("images after that", lambda a=at: len(renderer.frames()) > a + 1)
                check(screen.picture(window).rows == at_rest, f"{key} changed the images of --out")
            else:
                wait_until(f"what {key} shows", lambda r=rows: changed_rows() > r)
                check(len(seen_anywhere(screen.picture(window))) == 3, f"{key} hides the scene")
            screen.key(key)
            wait_until("what was there at first", lambda: screen.picture(window).rows == at_rest)
        screen.x11.close(window)
        renderer.expect_exit(0)


# Positions of the panels' controls in a window of this size, with only the lights panel open.
PANELS_SIZE = (640, 400)
PANELS = ("node", "joints", "measure", "cameras", "frame", "streams", "lights", "materials", "render", "plots", "log", "timeline")
FRAME_HEADER, LIGHTS_ROW, COLOUR, INTENSITY, DARKER = (470, 24), (475, 135), (570, 155), (572, 178), (535, 178)


def drag(screen, window, begin, end):
    """Drags with a pause after the press and images between the moves, as a user does."""
    screen.move(window, *begin)
    time.sleep(0.3)
    screen.press_here()
    time.sleep(0.3)
    steps = max(abs(end[0] - begin[0]) // 6, 1)
    for step in range(1, steps + 1):
        x, y = (b + (e - b) * step // steps for b, e in zip(begin, end))
        screen.move(window, x, y)
        time.sleep(0.05)
    screen.release()


def panels(test, screen):
    """Dragging a light's slider changes the light and not the view; Tab hides the panels; their layout is saved."""
    scene, arrangement = test.path("sun.glb"), test.path("config/fire3dv/window.conf")
    write_scene(scene, sun=True, place=0)
    os.makedirs(os.path.dirname(arrangement))
    with open(arrangement, "w", encoding="ascii") as file:
        for panel in ("scene", "node", "cameras", "frame", "streams", "materials", "render", "log"):
            file.write(f"{panel} = closed\n")
        file.write("lights = open\n")
    renderer = test.viewer(scene, env=screen.env, size=PANELS_SIZE)
    window = screen.window(renderer)

    def pixel(x, y):
        return screen.picture(window).pixel(x, y)
    red = (320, 66)
    wait_until("the red square between the panels", lambda: pixel(*red)[0] > 150 and pixel(*red)[1] < 60)
    before, panel = pixel(*red)[0], pixel(600, 300)
    screen.click(window, *LIGHTS_ROW)
    wait_until("the light's colour, which is white", lambda: min(pixel(*COLOUR)) > 200)
    drag(screen, window, INTENSITY, DARKER)
    wait_until("a darker square where it was", lambda: 20 < pixel(*red)[0] < before - 20)
    check(pixel(red[0], red[1] + 30)[0] == pixel(red[0] + 40, red[1])[0], "the view moved")
    screen.key("Tab")
    wait_until("no panels", lambda: pixel(600, 300) != panel)
    screen.key("Tab")
    wait_until("panels again", lambda: pixel(600, 300) == panel)
    screen.click(window, *FRAME_HEADER)
    wait_until("the other panel to open above it", lambda: min(pixel(*COLOUR)) < 200)
    screen.x11.close(window)
    renderer.wait_err("close again to discard it")  # the light
    screen.x11.close(window)
    renderer.expect_exit(0)
    with open(arrangement, encoding="ascii") as file:
        text = file.read()
    check("frame = open" in text and "streams = closed" in text, f"what was kept:\n{text}")


def captures(test, screen):
    """P takes screenshots with frame tags that never replace a file, V records a video."""
    folder = test.path("taken")
    uri = test.fresh_uri("shm")
    renderer, window = open_viewer(test, screen, "--screenshots", folder, listen=[uri])
    publisher = test.publisher(uri)
    publisher.do("publish 3")
    renderer.wait_frame("a frame of the stream", lambda f: f["streams"])
    screen.move(window, 100, 80)
    for _ in range(2):  # one at a time: key presses between two images count once
        screen.key("p")
        renderer.wait_err(r"screenshot .*\.png")
    pictures = wait_until("two pictures", lambda: (lambda found: len(found) == 2 and found)(
        [path for path in glob.glob(os.path.join(folder, "*.png")) if os.path.getsize(path)]))
    for path in pictures:
        picture = read_png(path)
        check((picture.width, picture.height) == SIZE and seen(picture) == set(AT), f"{path} shows {seen(picture)}")
        frame = next(f for f in renderer.frames() if str(f["frame"]) == picture.text["Frame"])
        check_tags(picture.text, {**frame, "file": path})
    screen.key("v")
    began = renderer.wait_err(r"recording (.*\.mp4)").group(1)
    at = len(renderer.frames())
    wait_until("images for the video", lambda: len(renderer.frames()) > at + 3)
    screen.key("v")
    renderer.wait_err(r"video .*\.mp4")
    check(os.path.getsize(began) > 0, "the video is empty")
    with open(began + ".jsonl", encoding="utf-8") as log:
        lines = [json.loads(line) for line in log]
    check(lines and all(line["streams"] for line in lines), f"{lines[:2]}")
    renderer.stop()
    publisher.quit()
    check(not glob.glob(os.path.join(folder, "*.part-*")), f"{os.listdir(folder)}")


def large_screenshot(test, screen):
    """A screenshot has the size of its option, not of the window; the window goes on."""
    folder = test.path("taken")
    renderer = test.viewer(test.scene, "--gui", "off", "--camera", "front", "--screenshots", folder, "--screenshot-size", "640x360",
                           env=screen.env, size=SIZE)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    at_rest = screen.picture(window).rows
    screen.key("p")
    renderer.wait_err(r"screenshot .*\.png")
    (path,) = glob.glob(os.path.join(folder, "*.png"))
    picture = read_png(path)
    check((picture.width, picture.height) == (640, 360) and seen(picture) == set(AT), f"{path} shows {seen(picture)}")
    wait_until("what was there at first", lambda: screen.picture(window).rows == at_rest)
    screen.key("ctrl+q")
    renderer.expect_exit(0)


def screenshot_above_the_device(test, screen):
    """Tiles make a screenshot that is larger than an image of lavapipe may be (16384 pixels a side)."""
    scene, side = test.path("middle.glb"), 17000
    write_scene(scene, place=0)
    renderer = test.viewer(scene, "--gui", "off", "--camera", "front", "--screenshots", test.path("taken"), "--screenshot-size",
                           f"4x{side}", env=screen.env, size=SIZE)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: len(seen_anywhere(screen.picture(window))) == 3)
    shown = screen.picture(window)
    screen.key("p")
    path = renderer.wait_err(r"screenshot (.*\.png)").group(1)
    taken = read_png(path)
    check((taken.width, taken.height) == (4, side), f"{taken.width}x{taken.height}")
    for name in AT:
        at, expected = taken.row_of(name), shown.row_of(name) * side / SIZE[1]
        check(at is not None and abs(at - expected) <= side / SIZE[1], f"{name} is in row {at}, not {expected}")
    screen.key("ctrl+q")
    renderer.expect_exit(0)


def several(test, screen):
    """One window per camera. Closing one leaves the others open; closing the first ends the program."""
    renderer = test.renderer("--window", "front", "--window", "camera of front", headless=False, size=SIZE, env=screen.env)
    first = screen.window(renderer, "^FIRE-3DV front$")
    second = screen.window(renderer, "^FIRE-3DV camera of front$")
    screen.x11.place(second, 300, 240)
    for window in (first, second):
        wait_until("all squares on the screen", lambda w=window: all_squares(screen.picture(w)))
    screen.click(second, 100, 80, button=4)
    wait_until("the second to zoom", lambda: not all_squares(screen.picture(second)))
    check(all_squares(screen.picture(first)), "the wheel in one window moved the other")
    screen.x11.close(second)
    wait_until("one window", lambda: screen.windows() == [first])
    at = len(renderer.frames())
    wait_until("images after that", lambda: len(renderer.frames()) > at + 1)
    screen.x11.close(first)
    renderer.expect_exit(0)


def cameras_of_windows(test, screen):
    """A window keeps its camera when another scene is loaded, also after an earlier window was closed."""
    scene, other = test.path("three cameras.glb"), test.path("red.glb")
    write_scene(scene, away=True)
    write_scene(other, {"red": ((1, 0, 0), 30)}, away=True)
    cameras = ("front", "away", "camera of front")
    renderer = test.viewer(scene, "--gui", "off", *(a for c in cameras for a in ("--window", c)), env=screen.env, size=SIZE)
    first, second, third = (screen.window(renderer, f"^FIRE-3DV {camera}$") for camera in cameras)
    screen.x11.place(third, 300, 240)
    wait_until("all squares in the third", lambda: all_squares(screen.picture(third)))
    screen.x11.close(second)
    wait_until("two windows", lambda: second not in screen.windows())
    screen.x11.drop(first, other, HANG_S)
    for window in (first, third):
        wait_until("red alone", lambda w=window: seen(screen.picture(w)) == {"red"})
    screen.x11.close(first)
    renderer.expect_exit(0)


def tiny(test, screen):
    """A window one pixel wide still has panels, and records no video."""
    folder = test.path("taken")
    renderer = test.viewer(test.scene, "--screenshots", folder, env=screen.env, size=(1, 200))
    window = screen.window(renderer)
    screen.move(window, 0, 100)
    screen.key("v")
    renderer.wait_err(r"the video ends: a side of the window")
    wait_until("no file of it", lambda: not os.listdir(folder))
    screen.x11.close(window)
    renderer.expect_exit(0)


def stereo(test, screen):
    """Two cameras side by side; the mouse moves the one under it."""
    renderer = test.renderer("--stereo", "front,camera of front", headless=False, size=(640, 180), env=screen.env)
    window = screen.window(renderer)

    def half(right):
        return all_squares(screen.picture(window).columns(320 * right, 320))
    wait_until("all squares in both halves", lambda: half(0) and half(1))
    screen.click(window, 420, 80, button=4)
    wait_until("the right half to zoom", lambda: not half(1))
    check(half(0), "the wheel in the right half moved the left one")
    renderer.stop()


def drop(test, screen):
    """A dropped scene replaces the shown one; an invalid one leaves it. An address that cannot be bound again is reported."""
    other, broken, key = test.path("other scene.glb"), test.path("broken.glb"), test.path("key")
    with open(os.open(key, os.O_WRONLY | os.O_CREAT, 0o600), "w", encoding="ascii") as file:
        file.write("0123456789abcdef" * 4 + "\n")
    write_scene(other, {"red": ((1, 0, 0), 30)})
    with open(broken, "wb") as file:
        file.write(b"glTF no more")
    renderer = test.viewer(test.scene, "--gui", "off", "--listen", test.fresh_uri("udp"), "--key-file", key, env=screen.env, size=SIZE)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    screen.x11.drop(window, broken, HANG_S)
    renderer.wait_err(r"broken\.glb: ")
    check(all_squares(screen.picture(window)), "a broken file took the scene away")
    screen.x11.drop(window, other, HANG_S)
    wait_until("red alone", lambda: seen(screen.picture(window)) == {"red"})
    with open(test.path("state/fire3dv/recent"), encoding="utf-8") as file:
        recent = file.read().splitlines()
    check(recent == [other, test.scene], f"recent files: {recent}")
    os.unlink(key)
    screen.x11.drop(window, test.scene, HANG_S)
    wait_until("all squares again", lambda: all_squares(screen.picture(window)))
    renderer.wait_err(r"key file .*no simulator can connect there now")
    screen.x11.close(window)
    renderer.expect_exit(0)


FILE_CHOICE, SECOND_FILE = (150, 47), (110, 93)  # in a window of PANELS_SIZE with only the scene panel open


def opens_recent(test, screen):
    """The panel Scene opens a file of an earlier run."""
    red = test.path("red.glb")
    write_scene(red, {"red": ((1, 0, 0), 30)})
    for path, lines in (("config/fire3dv/window.conf", [f"{panel} = closed" for panel in PANELS] + ["scene = open"]),
                        ("state/fire3dv/recent", [test.scene])):
        os.makedirs(os.path.dirname(test.path(path)))
        with open(test.path(path), "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
    renderer = test.viewer(red, "--camera", "auto", env=screen.env, size=PANELS_SIZE)
    window = screen.window(renderer)
    wait_until("red alone", lambda: seen_anywhere(screen.picture(window)) == {"red"})
    # The layout settles within the first images.
    pictures = [screen.picture(window).rows]

    def is_settled():
        pictures.append(screen.picture(window).rows)
        return pictures[-1] == pictures[-2] and len(pictures) > 5
    wait_until("a settled layout", is_settled)
    closed = pictures[-1]
    screen.click(window, *FILE_CHOICE)

    def list_is_open():
        return screen.picture(window).rows[SECOND_FILE[1]] != closed[SECOND_FILE[1]]
    wait_until("the list of files", list_is_open)
    screen.key("Escape")
    wait_until("no list", lambda: not list_is_open())
    check(renderer.alive(), "Escape in a list closed the window")
    screen.click(window, *FILE_CHOICE)
    wait_until("the list of files", list_is_open)
    screen.click(window, *SECOND_FILE)
    wait_until("all squares", lambda: len(seen_anywhere(screen.picture(window))) == 3)
    screen.x11.close(window)
    renderer.expect_exit(0)
    with open(test.path("state/fire3dv/recent"), encoding="utf-8") as file:
        check(file.read().splitlines() == [test.scene, red], "the list is in another order")


def closed_while_loading(test, screen):
    """Closing the window ends a load without an error."""
    large = test.path("large.glb")
    write_large_scene(large)
    renderer = test.renderer("--lod", "off", headless=False, size=SIZE, scene=large, env=screen.env)
    window = screen.window(renderer)
    screen.x11.close(window)
    renderer.expect_exit(0)
    check(not renderer.frames(), "it drew the scene first")


def tour(test, screen):
    """Runs the commands of docs/tour.md with other addresses and another size."""
    with open(TOUR, encoding="utf-8") as file:
        blocks = re.findall(r"```sh\n(.*?)```", file.read(), re.S)
    commands = [shlex.split(line) for block in blocks for line in block.splitlines()]
    check(len(commands) > 4 and all(c[0].startswith("./") for c in commands), f"{commands}")
    uri, names = test.fresh_uri("shm"), {"arm.glb": test.path("arm.glb"), "images": test.path("images")}

    def start(command):
        arguments = [names.get(word, uri if word.startswith("shm://") else word) for word in command[1:]]
        name = command[0].removeprefix("./")
        if name == "fire3dv":
            arguments += ["--size", "320x180", "--cache", "off", "--validation", "--frames", "3"]
        return Program(test, name, [test.programs_at[name], *arguments], env=screen.env)
    simulator = None
    for command in commands:
        program = start(command)
        if "--to" in command:
            simulator = program
        else:
            program.expect_exit(0)
    check(simulator and simulator.alive(), "the simulator ended")


def write_large_scene(path):
    """Writes many meshes that share their vertices: a small file that takes long to prepare."""
    side, meshes = 100, 300
    positions = b"".join(struct.pack("<3f", x, (x * 7 + y * 3) % 5, y) for y in range(side) for x in range(side))
    corners = [(y * side + x) for y in range(side - 1) for x in range(side - 1)]
    indices = b"".join(struct.pack("<6I", c, c + 1, c + side, c + 1, c + side + 1, c + side) for c in corners)
    binary = positions + indices
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(meshes))}],
        "nodes": [{"mesh": i, "translation": [i * side, 0, 0]} for i in range(meshes)],
        "meshes": [{"primitives": [primitive]} for _ in range(meshes)],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": side * side, "type": "VEC3",
                       "min": [0, 0, 0], "max": [side - 1, 4, side - 1]},
                      {"bufferView": 1, "componentType": 5125, "count": 6 * len(corners), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(positions)},
                        {"buffer": 0, "byteOffset": len(positions), "byteLength": len(indices)}],
        "buffers": [{"byteLength": len(binary)}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


CASES = {f.__name__: on_a_screen(f) for f in (selects, measures, focuses, guides, panels, captures, large_screenshot, screenshot_above_the_device, several, cameras_of_windows, tiny, stereo, drop,
                                              opens_recent, closed_while_loading)}
CASES_OF_THE_TOUR = {"tour": on_a_screen(tour)}

if __name__ == "__main__":
    if len(sys.argv) > 3 and sys.argv[3] == "tour":
        main(CASES_OF_THE_TOUR, ["fire3dv", "bullet_arm"])
    else:
        main(CASES, ["fire3dv", "publisher"])
