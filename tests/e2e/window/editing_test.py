#!/usr/bin/env python3
"""End-to-end test of editing in a window with real X input: the gizmo moves a body, keys undo and redo it, and the
saved overlay file gives the same image without a window, byte for byte; keys undo render settings, too.
"""
import glob
import json
import os

from glb_edit import add_variants
from harness import main, wait_until
from image_reader import check, read_png, write_scene
from screen import on_a_screen

WINDOW = (1000, 640)
COLOURS = {"red": (1, 0, 0), "blue": (0, 0, 1)}


def centre_of(picture, name, columns):
    """Centre of the pixels of this colour within these columns, or None."""
    wanted = COLOURS[name]
    found = [(x, y) for y in range(picture.height) for x in columns
             if all(c > 220 if w else c < 40 for c, w in zip(picture.pixel(x, y), wanted))]
    if not found:
        return None
    xs, ys = zip(*found)
    return (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2


def gizmo(test, screen):
    scene, folder = test.path("squares.glb"), test.path("taken")
    write_scene(scene, place=0)
    renderer = test.viewer(scene, "--screenshots", folder, env=screen.env, size=WINDOW)
    window = screen.window(renderer)
    columns = range(280, 680)  # between the panels

    def red():
        return centre_of(screen.picture(window), "red", columns)
    at_rest = wait_until("the red square", red)
    blue = centre_of(screen.picture(window), "blue", columns)
    # All nodes are at the world's origin, the centre of the image; the squares are at rows 30 and -10.
    origin = at_rest[0], at_rest[1] + (blue[1] - at_rest[1]) * 30 / 40
    plain = screen.picture(window).rows
    screen.xdotool("mousemove", "--window", window, round(at_rest[0]), round(at_rest[1]), "click", 1)
    wait_until("an outline", lambda: screen.picture(window).rows != plain)
    outlined = screen.picture(window).rows
    screen.xdotool("key", "g")
    wait_until("the gizmo", lambda: screen.picture(window).rows != outlined)
    way = 60, 40
    start = [round(c) for c in origin]
    screen.xdotool("mousemove", "--window", window, *start)
    screen.xdotool("mousedown", 1)
    for step in range(1, 11):
        screen.xdotool("mousemove", "--window", window, *(s + w * step // 10 for s, w in zip(start, way)))
    moved = [a + w for a, w in zip(at_rest, way)]

    def is_at(place):
        now = red()
        return now is not None and all(abs(a - b) <= 1.5 for a, b in zip(now, place))
    wait_until(lambda: f"the square at {moved}, not {red()}", lambda: is_at(moved))
    screen.xdotool("mouseup", 1)
    screen.xdotool("key", "ctrl+z")
    wait_until(lambda: f"the square at rest, not {red()}", lambda: is_at(at_rest))
    screen.xdotool("key", "ctrl+y")
    wait_until("the square moved again", lambda: is_at(moved))
    screen.xdotool("key", "ctrl+s")
    renderer.wait_err(r"1 edit saved to .*squares\.glb\.overlay\.json")
    screen.xdotool("key", "ctrl+shift+s")
    exported = renderer.wait_err(r"scene exported to (.*squares\.edited\.glb)").group(1)
    screen.xdotool("key", "Escape")
    screen.xdotool("key", "Escape")  # no gizmo, no selection
    screen.xdotool("mousemove", "--window", window, columns[5], 20)
    screen.xdotool("key", "p")
    taken = renderer.wait_err(r"screenshot (.*\.png)").group(1)
    picture = wait_until("the screenshot", lambda: os.path.exists(taken) and os.path.getsize(taken) and read_png(taken))
    screen.x11.close(int(window))
    renderer.expect_exit(0)
    overlay = scene + ".overlay.json"
    with open(overlay, encoding="utf-8") as file:
        entries = json.load(file)["fire3dv_overlay"]["edits"]
    check([set(e) for e in entries] == [{"node", "translation", "rotation", "scale"}], f"{entries}")

    def image(*arguments, of=scene):
        run = test.renderer(*arguments, "--frames", "1", scene=of, size=(picture.width, picture.height))
        run.expect_exit(0)
        return read_png(glob.glob(os.path.join(run.folder, "*.png"))[0]).rows
    check(image("--overlay", overlay) == picture.rows, "the saved scene has another image")
    check(image(of=exported) == picture.rows, "the exported scene has another image")
    check(image() != picture.rows, "the edit is not seen")


def render_settings(test, screen):
    """Exposure, dragged in the panel Render, is undone and redone by keys."""
    scene, arrangement = test.path("lit.glb"), test.path("config/fire3dv/window.conf")
    write_scene(scene, place=0, sun=True)
    os.makedirs(os.path.dirname(arrangement))
    with open(arrangement, "w", encoding="ascii") as file:
        for panel in ("scene", "node", "cameras", "frame", "streams", "lights", "materials", "log"):
            file.write(f"{panel} = closed\n")
        file.write("render = open\nleft-dock = folded\n")
    renderer = test.viewer(scene, env=screen.env, size=(640, 480))
    window = screen.window(renderer)

    def brightness():
        picture = screen.picture(window)
        return max(picture.pixel(x, y)[0] - picture.pixel(x, y)[1] for x in range(60, 400, 4) for y in range(0, 480, 4))

    def exposure_grab():
        """Centre of the uppermost slider grab, in the accent colour of the theme."""
        picture = screen.picture(window)
        for y in range(picture.height):
            xs = [x for x in range(440, 640) if all(abs(picture.pixel(x, y)[i] - (0x4a, 0xa3, 0xdf)[i]) < 12 for i in range(3))]
            if 4 <= len(xs) <= 16:
                return sum(xs) // len(xs), y + 4
        return None
    before = wait_until("a red square", lambda: (lambda now: now if now > 60 else None)(brightness()))
    x, y = wait_until("a slider", exposure_grab)
    screen.xdotool("mousemove", "--window", window, x, y, "mousedown", 1)
    for step in range(1, 7):
        screen.xdotool("mousemove", "--window", window, x - 5 * step, y)
    screen.xdotool("mouseup", 1)
    wait_until("a darker square", lambda: brightness() < before / 2)
    screen.xdotool("mousemove", "--window", window, 200, 300)
    screen.xdotool("key", "ctrl+z")
    wait_until(lambda: f"the square as it was, {before}, not {brightness()}", lambda: brightness() == before)
    screen.xdotool("key", "ctrl+y")
    wait_until("a darker square again", lambda: brightness() < before / 2)
    screen.x11.close(int(window))
    renderer.expect_exit(0)


def bad_files(test):
    """A file that is no overlay, or names a wrong member, ends the program with both in the message."""
    for text, fault in (('{"fire3dv_overlay": {"version": 1, "edits": [{"node": "red", "visble": 1}]}}', 'edits\\[0\\].*"visble"'),
                        ("glTF", "JSON is invalid"), (None, "bad.json")):
        overlay = test.path("bad.json")
        if text is None:
            os.unlink(overlay)
        else:
            with open(overlay, "w", encoding="ascii") as file:
                file.write(text)
        renderer = test.renderer("--overlay", overlay, "--frames", "1")
        renderer.expect_exit(1)
        renderer.wait_err(f"bad.json.*{fault}" if text else fault)
    with open(overlay, "w", encoding="ascii") as file:
        file.write('{"fire3dv_overlay": {"version": 1, "edits": [{"node": "nobody", "visible": false}]}}')
    renderer = test.renderer("--overlay", overlay, "--frames", "1")
    renderer.expect_exit(0)
    renderer.wait_err(r'warning: .*visibility of node "nobody" has no effect')


def variants(test):
    """The overlay chooses a material variant, and --variant overrides it."""
    scene, overlay = add_variants(test.scene, test.path("variants.glb"), {"leaf": "green", "sea": "blue"}), test.path("leaf.json")
    with open(overlay, "w", encoding="ascii") as file:
        file.write('{"fire3dv_overlay": {"version": 1, "edits": [{"variant": "leaf"}]}}')

    def rows(*arguments):
        run = test.renderer(*arguments, "--frames", "1", scene=scene)
        run.expect_exit(0)
        return read_png(glob.glob(os.path.join(run.folder, "*.png"))[0]).rows
    leaf, sea = rows("--variant", "leaf"), rows("--variant", "sea")
    check(leaf != sea, "the variants look alike")
    check(rows("--overlay", overlay) == leaf, "the overlay's variant is not shown")
    check(rows("--overlay", overlay, "--variant", "sea") == sea, "--variant does not replace that of the overlay")


if __name__ == "__main__":
    main({"gizmo": on_a_screen(gizmo, size=(1280, 800)), "render_settings": on_a_screen(render_settings), "bad_files": bad_files,
          "variants": variants}, ["fire3dv"])
