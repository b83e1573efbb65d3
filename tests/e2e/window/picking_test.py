#!/usr/bin/env python3
"""End-to-end test of clicks in a window with all panels open: skinned, morphed and instanced bodies are selected, each
by itself, and the panels show what was clicked.
"""
import json
import os
import struct

from glb_edit import edit_glb
from harness import HANG_S, main, wait_until
from image_reader import check, ranges_of, write_scene
from screen import OUTLINE, on_a_screen

WINDOW, COLUMNS = (900, 640), (270, 310)  # the image between the panels
SEARCH, FIRST_ROW = (120, 42), (120, 66)  # of the panel Scene
PANELS = ("scene", "node", "cameras", "frame", "streams", "lights", "materials", "render", "log", "timeline", "joints",
          "plots", "measure", "edit", "controls")
ASSETS = os.environ.get("FIRE3DV_ASSETS") or os.path.join(os.path.dirname(os.path.abspath(__file__)), *[".."] * 4, "shared", "assets")
SAMPLES = ("khronos-sample-models/RiggedSimple/glTF-Binary/RiggedSimple.glb",
           "khronos-sample-models/RiggedFigure/glTF-Binary/RiggedFigure.glb",
           "khronos-sample-models/AnimatedMorphCube/glTF-Binary/AnimatedMorphCube.glb",
           "bevy/Fox.glb", "gltf-asset-generator/Instancing/Instancing_00.gltf",
           "gltf-asset-generator/Animation_Skin/Animation_Skin_00.gltf")


def write_deformed_scene(path):
    """Squares: red has a skin with one bone, green a morph target, blue is instanced, once."""
    def change(document, binary):
        def add(data, kind, component, count, **more):
            nonlocal binary
            document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
            document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": component,
                                          "count": count, "type": kind, **more})
            binary += data + b"\0" * (-len(data) % 4)
            return len(document["accessors"]) - 1

        red, green, blue = ({"node": node, "mesh": document["meshes"][node["mesh"]]["primitives"][0]}
                            for node in document["nodes"][:3])
        red["mesh"]["attributes"]["JOINTS_0"] = add(bytes(16), "VEC4", 5121, 4)
        red["mesh"]["attributes"]["WEIGHTS_0"] = add(struct.pack("<4f", 1, 0, 0, 0) * 4, "VEC4", 5126, 4)
        document["nodes"].append({"name": "bone"})
        document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
        document["skins"] = [{"joints": [len(document["nodes"]) - 1]}]
        red["node"]["skin"] = 0
        green["mesh"]["targets"] = [{"POSITION": add(struct.pack("<3f", 0, 0, 1) * 4, "VEC3", 5126, 4, min=[0, 0, 1], max=[0, 0, 1])}]
        document["meshes"][green["node"]["mesh"]]["weights"] = [0.5]
        blue["node"]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {
            "TRANSLATION": add(struct.pack("<3f", 0, 0, 0), "VEC3", 5126, 1)}}}
        document["extensionsUsed"].append("EXT_mesh_gpu_instancing")
        return binary
    plain = path + ".plain.glb"
    write_scene(plain, place=0)
    return edit_glb(plain, path, change)


def open_window(test, screen, scene, *options):
    conf = test.path("config/fire3dv/window.conf")
    os.makedirs(os.path.dirname(conf))
    with open(conf, "w", encoding="utf-8") as file:
        file.write("\n".join(f"{panel} = open" for panel in PANELS) + "\n")
    renderer = test.viewer(scene, "--shadows", "off", "--samples", "1", "--fxaa", "off", *options, env=screen.env, size=WINDOW)
    return renderer, screen.window(renderer)


def outlined_rows(screen, window):
    """Rows of the image with pixels of an outline."""
    return [y for y, row in enumerate(screen.picture(window).columns(*COLUMNS).rows) if OUTLINE in row]


def deformed(test, screen):
    renderer, window = open_window(test, screen, write_deformed_scene(test.path("deformed.glb")))

    def box(name):
        return screen.picture(window).box_of(ranges_of(name), COLUMNS[0], sum(COLUMNS))
    for name in ("red", "green", "blue"):
        at = wait_until(f"the {name} square", lambda n=name: box(n))
        screen.click(window, (at[0] + at[2]) // 2, (at[1] + at[3]) // 2)

        def is_outlined():
            check(renderer.alive(), f"a click on {name} ended the program:\n{renderer.stderr_text()}")
            rows = outlined_rows(screen, window)
            return rows and at[1] - 8 < min(rows) and max(rows) < at[3] + 8
        wait_until(f"an outline of {name} alone", is_outlined)
    screen.key("ctrl+q")
    renderer.expect_exit(0)


def added(test, screen):
    """An added group of deformed bodies, far smaller than the scene: its row draws its outline, and F frames it."""
    scene, overlay = test.path("squares.glb"), test.path("overlay/add.json")
    write_scene(scene, place=0)
    os.makedirs(os.path.dirname(overlay))
    write_deformed_scene(test.path("overlay/group.glb"))
    with open(overlay, "w", encoding="ascii") as file:
        json.dump({"fire3dv_overlay": {"version": 2, "edits": [
            {"add": "group", "asset": "group.glb", "translation": [20, 0, 0], "rotation": [0, 0, 0, 1], "scale": [0.05] * 3}]}}, file)
    renderer, window = open_window(test, screen, scene, "--overlay", overlay)
    wait_until("an image", lambda: len(set(screen.picture(window).columns(*COLUMNS).rows)) > 8)
    screen.click(window, *SEARCH)
    screen.key(*"group")
    screen.click(window, *FIRST_ROW)
    rows = wait_until("the outline of the group", lambda: outlined_rows(screen, window))
    check(max(rows) - min(rows) < 40, f"the outline of the small group is in rows {rows}")
    screen.move(window, COLUMNS[0] + COLUMNS[1] // 2, 300)
    screen.key("f")

    def is_framed():
        rows = outlined_rows(screen, window)
        return rows and max(rows) - min(rows) > 150
    wait_until("the group to fill the image", is_framed)
    screen.key("ctrl+q")
    renderer.expect_exit(0)


def samples(test, screen):
    files = [path for path in (os.path.normpath(os.path.join(ASSETS, name)) for name in SAMPLES) if os.path.exists(path)]
    if not files:
        print(f"skipped: no sample models in {ASSETS}")
        return
    renderer, window = open_window(test, screen, files[0])
    for number, path in enumerate(files):
        if number > 0:
            screen.key("Escape")
            wait_until("no outline", lambda: not outlined_rows(screen, window))
            screen.x11.drop(window, path, HANG_S)
            wait_until(f"{path} as the window's scene", lambda n=number: recent(test)[:1] == [files[n]])
        wait_until("an image", lambda: len(set(screen.picture(window).columns(*COLUMNS).rows)) > 8)

        def selects():
            for step in range(25):  # over the middle of the image
                screen.click(window, COLUMNS[0] + COLUMNS[1] * (2 + step % 5) // 8, 100 + 60 * (step // 5))
                for _ in range(10):
                    check(renderer.alive(), f"a click on {path} ended the program:\n{renderer.stderr_text()}")
                    if outlined_rows(screen, window):
                        return True
            return False
        wait_until(f"an outline in {path}", selects)
    screen.key("ctrl+q")
    renderer.expect_exit(0)


def recent(test):
    try:
        with open(test.path("state/fire3dv/recent"), encoding="utf-8") as file:
            return file.read().splitlines()
    except FileNotFoundError:
        return []


CASES = {f.__name__: on_a_screen(f, size=(1000, 700)) for f in (deformed, added, samples)}

if __name__ == "__main__":
    main(CASES, ["fire3dv"])
