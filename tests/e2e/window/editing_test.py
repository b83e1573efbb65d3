#!/usr/bin/env python3
"""End-to-end test of editing in a window with real X input: the gizmo moves a body, keys undo and redo it, and the
saved overlay file gives the same image without a window, byte for byte; keys undo render settings, too.
"""
import glob
import json
import os
import signal

from glb_edit import add_variants, edit_glb
from harness import main, wait_until
from image_reader import SIZE, check, ranges_about, ranges_of, read_png, write_scene
from screen import on_a_screen

WINDOW = (1000, 640)
ACCENT = (0x4a, 0xa3, 0xdf)  # of the theme, in which grabs of sliders are drawn
WARNING = (0xe6, 0xb4, 0x50)


def centre_of(picture, name, columns):
    """Centre of the pixels of this colour within these columns, or None."""
    box = picture.box_of(ranges_of(name, high=220, low=40), columns.start, columns.stop)
    return box and ((box[0] + box[2] - 1) / 2, (box[1] + box[3] - 1) / 2)


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
    screen.click(window, round(at_rest[0]), round(at_rest[1]))
    outlined = screen.wait_outline(window, (280, 400)).rows
    screen.key("g")
    wait_until("the gizmo", lambda: screen.picture(window).columns(280, 400).rows != outlined)
    way = 60, 40
    start = [round(c) for c in origin]
    screen.move(window, *start)
    screen.press_here()
    for step in range(1, 11):
        screen.move(window, *(s + w * step // 10 for s, w in zip(start, way)))
    moved = [a + w for a, w in zip(at_rest, way)]

    def is_at(place):
        now = red()
        return now is not None and all(abs(a - b) <= 1.5 for a, b in zip(now, place))
    wait_until(lambda: f"the square at {moved}, not {red()}", lambda: is_at(moved))
    screen.release()
    screen.key("ctrl+z")
    wait_until(lambda: f"the square at rest, not {red()}", lambda: is_at(at_rest))
    screen.key("ctrl+y")
    wait_until("the square moved again", lambda: is_at(moved))
    screen.key("ctrl+s")
    renderer.wait_err(r"1 edit saved to .*squares\.glb\.overlay\.json")
    screen.key("ctrl+shift+s")
    exported = renderer.wait_err(r"scene exported to (.*squares\.edited\.glb)").group(1)
    screen.key("Escape")
    screen.key("Escape")  # no gizmo, no selection
    screen.move(window, columns[5], 20)
    screen.key("p")
    taken = renderer.wait_err(r"screenshot (.*\.png)").group(1)
    picture = wait_until("the screenshot", lambda: os.path.exists(taken) and os.path.getsize(taken) and read_png(taken))
    screen.x11.close(window)
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
        for y, row in enumerate(screen.picture(window).matches(ranges_about(ACCENT, 12), 440, 640)):
            if 4 <= row.count(1) <= 16:
                return 440 + (row.find(1) + row.rfind(1)) // 2, y + 4
        return None
    before = wait_until("a red square", lambda: (lambda now: now if now > 60 else None)(brightness()))
    x, y = wait_until("a slider", exposure_grab)
    screen.press(window, x, y)
    for step in range(1, 7):
        screen.move(window, x - 5 * step, y)
    screen.release()
    wait_until("a darker square", lambda: brightness() < before / 2)
    screen.move(window, 200, 300)
    screen.key("ctrl+z")
    wait_until(lambda: f"the square as it was, {before}, not {brightness()}", lambda: brightness() == before)
    screen.key("ctrl+y")
    wait_until("a darker square again", lambda: brightness() < before / 2)
    screen.x11.close(window)
    renderer.expect_exit(0)


def adding(test, screen):
    """Ctrl+D duplicates a body, the gizmo moves the copy alone, Del and Ctrl+Z take it away and back; overlay file and
    exported scene give the image of the window.
    """
    scene, folder = test.path("bodies.glb"), test.path("taken")
    write_scene(scene, place=0)
    renderer = test.viewer(scene, "--screenshots", folder, env=screen.env, size=WINDOW)
    window = screen.window(renderer)
    columns = range(280, 680)  # between the panels

    at_rest = wait_until("the red square", lambda: centre_of(screen.picture(window), "red", columns))

    def reds():
        """Left and right edge of the red pixels of the square's row, or None."""
        row = screen.picture(window).matches(ranges_of("red", high=220, low=40), columns.start, columns.stop)[round(at_rest[1])]
        return (columns.start + row.find(1), columns.start + row.rfind(1)) if 1 in row else None
    left, right = reds()
    blue = centre_of(screen.picture(window), "blue", columns)
    origin = round(at_rest[0]), round(at_rest[1] + (blue[1] - at_rest[1]) * 30 / 40)
    screen.click(window, round(at_rest[0]), round(at_rest[1]))
    screen.wait_outline(window, (280, 400))
    screen.key("ctrl+d")
    renderer.wait_err(r'added "red\.1"')
    outlined = screen.wait_outline(window, (280, 400)).rows
    screen.key("g")
    wait_until("the gizmo", lambda: screen.picture(window).columns(280, 400).rows != outlined)
    screen.move(window, *origin)
    screen.press_here()
    for step in range(1, 11):
        screen.move(window, origin[0] + 8 * step, origin[1])
    screen.release()

    def is_wide():
        now = reds()
        return now is not None and abs(now[0] - left) <= 1 and abs(now[1] - right - 80) <= 2
    wait_until(lambda: f"two red squares from {left} to {right + 80}, not {reds()}", is_wide)
    screen.key("Delete")
    wait_until(lambda: f"one red square, not {reds()}", lambda: reds() == (left, right))
    screen.key("ctrl+z")
    wait_until(lambda: f"both squares again, not {reds()}", is_wide)
    screen.key("ctrl+s")
    renderer.wait_err(r"2 edits saved to .*bodies\.glb\.overlay\.json")
    screen.key("ctrl+shift+s")
    exported = renderer.wait_err(r"scene exported to (.*bodies\.edited\.glb)").group(1)
    screen.x11.close(window)
    renderer.expect_exit(0)
    of_overlay = image_of(test, scene, "--overlay", scene + ".overlay.json")[1].rows
    check(of_overlay == image_of(test, exported)[1].rows, "the exported scene has another image than the overlay")
    check(of_overlay != image_of(test, scene)[1].rows, "the copy is not seen")


def unsaved(test, screen):
    """Edits that are not saved: the first Ctrl+Q or close says so in the window and leaves it open, the second closes it."""
    scene = test.path("squares.glb")
    write_scene(scene, place=0)

    def image():
        return screen.picture(window).columns(280, 400).rows

    def red():
        return centre_of(screen.picture(window), "red", range(280, 680))

    def told(times):
        found = [line for line in list(renderer.err) if line.endswith(
            "warning: 1 edit is not saved: Ctrl+S saves it; close again to discard it")]
        return len(found) == times

    renderer = test.viewer(scene, env=screen.env, size=WINDOW)
    window = screen.window(renderer)
    at = wait_until("the red square", red)
    screen.click(window, *map(round, at))
    screen.wait_outline(window, (280, 400))
    screen.key("h", "Escape")  # no selection
    wait_until("no red", lambda: not red())
    top = image()[:60]
    screen.key("ctrl+q")
    wait_until("the warning", lambda: told(1))
    wait_until("the notice", lambda: image()[:60] != top)
    screen.key("ctrl+z")
    wait_until("red again", red)
    screen.key("ctrl+y")
    wait_until("no red", lambda: not red())
    screen.x11.close(window)
    wait_until("the warning again: the edits have changed", lambda: told(2))
    check(renderer.alive(), "closed with unsaved edits")
    screen.x11.close(window)
    renderer.expect_exit(0)
    check(not os.path.exists(scene + ".overlay.json") and told(2), renderer.stderr_text())


def recovery(test, screen):
    """Edits that were not saved when the program was killed or the terminal closed: the next window asks about them."""
    scene = test.path("squares.glb")
    recovered = scene + ".overlay.recovery.json"
    write_scene(scene, place=0)

    def red(window):
        return centre_of(screen.picture(window), "red", range(280, 680))

    def hide_red():
        renderer = test.viewer(scene, env=screen.env, size=WINDOW)
        window = screen.window(renderer)
        screen.click(window, *map(round, wait_until("the red square", lambda: red(window))))
        screen.wait_outline(window, (280, 400))
        screen.key("h", "Escape")
        wait_until("no red", lambda: not red(window))
        return renderer

    renderer = hide_red()
    wait_until("the recovery file", lambda: os.path.exists(recovered))
    renderer.kill()
    os.unlink(recovered)
    renderer = hide_red()
    renderer.signal(signal.SIGHUP)
    renderer.expect_exit(0)
    check(renderer.find_err(r"warning: 1 unsaved edit stored in .*squares\.glb\.overlay\.recovery\.json"), renderer.stderr_text())
    drawn, _ = image_of(test, scene)
    check(drawn.find_err(r"warning: 1 edit of an earlier run was not saved: .*; --overlay .*recovery\.json applies"), drawn.stderr_text())

    renderer = test.viewer(scene, env=screen.env, size=WINDOW)
    window = screen.window(renderer)
    renderer.wait_err("apply or discard them in the window")
    wait_until("the red square", lambda: red(window))

    def question():
        """Left and lowest pixels of the question's border in the colour of warnings."""
        rows = screen.picture(window).matches(ranges_about(WARNING, 12), 280, 720)[:200]
        lines = [y for y, row in enumerate(rows) if row.count(1) > 120]
        return (280 + rows[lines[-1]].find(1), lines[-1]) if len(lines) > 1 else None
    def apply():
        # The question moves while the panels take their places.
        asked = question()
        if asked:
            screen.move(window, asked[0] + 24, asked[1] - 16)
            screen.press_here()
            screen.release()
        return renderer.find_err("1 edit of the earlier run applied")
    wait_until("the edits to be applied", apply)
    wait_until("no red", lambda: not red(window))
    screen.key("ctrl+s")
    renderer.wait_err(r"1 edit saved to .*squares\.glb\.overlay\.json")
    wait_until("no recovery file", lambda: not os.path.exists(recovered))
    screen.x11.close(window)
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


def image_of(test, scene, *arguments, size=(160, 120)):
    run = test.renderer(*arguments, "--frames", "1", scene=scene, size=size)
    run.expect_exit(0)
    return run, read_png(glob.glob(os.path.join(run.folder, "*.png"))[0])


def additions(test):
    """An overlay file adds a light, a camera, a copy and an asset: the image of a scene that has them, byte for byte. What cannot be
    added is named, and the rest is there.
    """
    scene, same, overlay = test.path("lit.glb"), test.path("same.glb"), test.path("overlay/add.json")
    write_scene(scene, sun=True, place=0)
    # A light over three squares of which one is a copy, placed as the overlay file places them.
    place = {"translation": [20, -5, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}
    lamp = {"type": "point", "color": [1, 0.5, 0.25], "intensity": 400}
    at_lamp = {"translation": [10, 10, 20], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}
    at_camera = {"translation": [5, 0, 50], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}
    camera = {"half_extent": [SIZE[0] / 2, SIZE[1] / 2], "near": 1, "far": 100}

    def change(document, binary):
        red = next(node for node in document["nodes"] if node["name"] == "red")
        document["extensions"]["KHR_lights_punctual"]["lights"].append(lamp)
        added = [{"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 1}}, **at_lamp},
                 {"name": "mine", "camera": 0, **at_camera}, {**red, "name": "red.1", **place}]
        document["scenes"][0]["nodes"] += range(len(document["nodes"]), len(document["nodes"]) + len(added))
        document["nodes"] += added
        return binary
    edit_glb(scene, same, change)
    os.makedirs(os.path.dirname(overlay))

    def write_overlay(*edits):
        with open(overlay, "w", encoding="ascii") as file:
            json.dump({"fire3dv_overlay": {"version": 2, "edits": [
                {"add": "lamp", "light": lamp, **at_lamp}, {"add": "mine", "camera": camera, **at_camera}, {"add": "red.1", "copy": "red", **place}, *edits]}}, file)
    expected = image_of(test, same, "--camera", "mine")[1].rows
    # Files outside of the overlay file's folder are not reached; one inside is drawn.
    write_scene(test.path("outside.glb"), {"red": ((1, 0, 0), 0)})
    os.symlink(test.path("outside.glb"), test.path("overlay/link.glb"))
    with open(test.path("overlay/broken.glb"), "wb") as file:
        file.write(b"glTF")
    write_overlay({"add": "up", "asset": "../outside.glb"}, {"add": "far", "asset": test.path("outside.glb")},
                  {"add": "link", "asset": "link.glb"}, {"add": "none", "asset": "none.glb"},
                  {"add": "broken", "asset": "broken.glb"}, {"add": "lost", "copy": "nobody"})
    run, picture = image_of(test, scene, "--overlay", overlay, "--camera", "mine")
    check(picture.rows == expected, "the overlay has another image than the scene")
    for name, reason in (("up", "leaves"), ("far", "absolute"), ("link", "link that leaves"), ("none", "none.glb"),
                         ("broken", "broken.glb"), ("lost", '"nobody", which it copies')):
        run.wait_err(f'warning: .*add.json: the node "{name}" is not added: .*{reason}')
    write_scene(test.path("overlay/inside.glb"), {"red": ((1, 0, 0), 0)}, place=0)
    write_overlay({"add": "inside", "asset": "inside.glb", "translation": [-40, 0, 1], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]},
                  {"node": "inside/red", "visible": True})
    run, picture = image_of(test, scene, "--overlay", overlay, "--camera", "mine")
    check(picture.rows != expected, "the asset is not drawn")
    check(not run.find_err("not added|no effect"), run.stderr_text())


if __name__ == "__main__":
    main({"gizmo": on_a_screen(gizmo, size=(1280, 800)), "adding": on_a_screen(adding, size=(1280, 800)),
          "unsaved": on_a_screen(unsaved, size=(1280, 800)), "recovery": on_a_screen(recovery, size=(1280, 800)),
          "render_settings": on_a_screen(render_settings),
          "bad_files": bad_files, "variants": variants, "additions": additions}, ["fire3dv"])
