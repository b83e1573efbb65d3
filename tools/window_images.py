#!/usr/bin/env python3
"""Makes the images of docs/ that show the window, the debug views and two simulators:
tools/window_images.py BIN FOLDER [NAME ...]

BIN is the folder of the built programs, NAME an image such as editing.png (default: all). Needs Xvfb, libXtst and ffmpeg.
"""
import os
import shutil
import subprocess
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "..", "tests", "e2e", "support"))
from harness import Program, Test, wait_until  # noqa: E402
from screen import Screen  # noqa: E402

VIEWS = ("normals", "depth", "instances", "clusters", "overdraw", "unresolved-shadows")


def write_png(picture, path):
    """With a palette of 256 colours, which keeps the files small."""
    subprocess.run(["ffmpeg", "-y", "-v", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{picture.width}x{picture.height}",
                    "-i", "-", "-filter_complex", "split[a][b];[a]palettegen=reserve_transparent=0[p];[b][p]paletteuse=dither=none",
                    "-frames:v", "1", "-compression_level", "9", path],
                   input=b"".join(picture.rows), check=True)


def await_images(screen, shown, count):
    """Waits until the window has shown so many further images of the moving arm, however slow the machine is."""
    before = None
    while count > 0:
        time.sleep(0.3)
        now = screen.picture(shown).rows
        if any(any(row) for row in now) and now != before:
            before, count = now, count - 1


def window(programs, folder, name, size, dpi, link):
    """A screenshot of the window while bullet_arm moves the scene. link: where to click for a selected link."""
    test = Test({})
    screen = Screen(test, size=size, dpi=dpi)
    try:
        arm, uri = test.path("arm.glb"), "shm://demo"  # shown in the panel, as a user has it
        subprocess.run([f"{programs}/bullet_arm", "--write-scene", arm], check=True, stdout=subprocess.DEVNULL)
        viewer = Program(test, "fire3dv", [f"{programs}/fire3dv", arm, "--listen", uri, "--size", f"{size[0]}x{size[1]}",
                                          "--shadows", "map"], env=screen.env)
        shown = screen.window(viewer)
        Program(test, "bullet_arm", [f"{programs}/bullet_arm", "--to", uri, "--realtime", "--loop"])
        viewer.wait_err("accepted")
        await_images(screen, shown, 25)  # the arm has begun to work
        screen.click(shown, *link)
        screen.move(shown, int(size[0] * 0.4), 2)
        await_images(screen, shown, 5)  # panels show the selected body
        wait_until("a screenshot", lambda: write_png(screen.picture(shown), os.path.join(folder, name)) is None)
    finally:
        test.end()
        screen.end()


def settled(screen, shown):
    """The window after its image has stopped to change."""
    before = None
    while True:
        time.sleep(3)
        now = screen.picture(shown)
        if before and now.rows == before.rows:
            return now
        before = now


def editing(programs, folder, name, size, dpi, body):
    """The gizmo over a body that was clicked and dragged: the centre of the gizmo is that of the body."""
    test = Test({})
    screen = Screen(test, size=size, dpi=dpi)
    try:
        arm, layout = test.path("arm.glb"), test.path("config/fire3dv/window.conf")
        subprocess.run([f"{programs}/bullet_arm", "--write-scene", arm], check=True, stdout=subprocess.DEVNULL)
        os.makedirs(os.path.dirname(layout))
        with open(layout, "w", encoding="ascii") as file:
            file.write("edit = open\nright-dock = folded\nbottom-dock = folded\n")
            file.writelines(f"{panel} = closed\n" for panel in ("node", "measure", "cameras"))
        viewer = Program(test, "fire3dv", [f"{programs}/fire3dv", arm, "--size", f"{size[0]}x{size[1]}", "--shadows", "map"],
                         env=screen.env)
        shown = screen.window(viewer)
        settled(screen, shown)
        screen.click(shown, *body)
        settled(screen, shown)
        screen.key("g")
        settled(screen, shown)
        screen.press(shown, *body)
        for step in range(1, 9):
            screen.move(shown, body[0] - dpi * step // 24, body[1] - dpi * step // 12)
        screen.release()
        screen.move(shown, int(size[0] * 0.4), 4)
        picture = settled(screen, shown)
        write_png(picture, os.path.join(folder, name))
    finally:
        test.end()
        screen.end()


def two_simulators(programs, folder, name):
    """The scene of examples/two_simulators after both have moved it for a while."""
    test = Test({})
    try:
        scene, uris = test.path("two.glb"), [test.fresh_uri("shm"), test.fresh_uri("shm")]
        subprocess.run([f"{programs}/two_simulators_scene", scene], check=True, stdout=subprocess.DEVNULL)
        for uri, engine in zip(uris, ("bullet", "mujoco")):
            Program(test, engine, [f"{programs}/two_simulators_{engine}", "--to", uri])
        subprocess.run([f"{programs}/fire3dv", scene, "--listen", uris[0], "--listen", uris[1], "--headless", "--wait-for-stream", "60",
                        "--frames", "12", "--size", "720x405", "--out", test.path("two"), "--cache", "off"], check=True,
                       stderr=subprocess.DEVNULL)
        shutil.copy(test.path("two/frame_000011.png"), os.path.join(folder, name))
    finally:
        test.end()


def views(programs, folder, name):
    test = Test({})
    try:
        arm = test.path("arm.glb")
        subprocess.run([f"{programs}/bullet_arm", "--write-scene", arm], check=True, stdout=subprocess.DEVNULL)
        inputs = []
        for view in VIEWS:
            subprocess.run([f"{programs}/fire3dv", arm, "--headless", "--frames", "2", "--size", "960x540", "--camera", "camera_front",
                            "--view", view, "--out", test.path(view), "--cache", "off"], check=True, stderr=subprocess.DEVNULL)
            inputs += ["-i", os.path.join(test.path(view), "frame_000001.png")]
        small = "".join(f"[{i}]scale=480:270:flags=area[v{i}];" for i in range(len(VIEWS)))
        stack = "".join(f"[v{i}]" for i in range(len(VIEWS)))
        subprocess.run(["ffmpeg", "-y", "-v", "error", *inputs, "-filter_complex",
                        f"{small}{stack}xstack=inputs=6:layout=0_0|w0_0|w0+w0_0|0_h0|w0_h0|w0+w0_h0[o]", "-map", "[o]", "-pix_fmt",
                        "rgb24", "-compression_level", "9", "-pred", "mixed", os.path.join(folder, name)], check=True)
    finally:
        test.end()


if __name__ == "__main__":
    BIN, FOLDER, NAMES = os.path.abspath(sys.argv[1]), sys.argv[2], sys.argv[3:]
    IMAGES = {"views.png": (views,), "two_simulators.png": (two_simulators,),
              "window.png": (window, (1280, 720), 96, (612, 256)),
              "window_640x400.png": (window, (640, 400), 96, (320, 118)),
              "window_scale_2.png": (window, (1280, 720), 192, (640, 208)),
              "editing.png": (editing, (960, 540), 96, (788, 396))}
    if unknown := set(NAMES) - set(IMAGES):
        sys.exit(f"window_images.py: no image is named {', '.join(sorted(unknown))}; there are {', '.join(IMAGES)}")
    for image in NAMES or IMAGES:
        make, *arguments = IMAGES[image]
        make(BIN, FOLDER, image, *arguments)
