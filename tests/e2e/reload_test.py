#!/usr/bin/env python3
"""End-to-end test of reloads: a scene that changes on disk replaces the displayed one when it is whole, streams keep
driving its nodes by name, and a broken version is reported once."""
import os
import time

from harness import main, wait_until
from image_reader import PLACE_AT_REST, SQUARES, check, expect_square, place_of, write_scene

OTHER_PLACE = -20.0
SETTLED_S = 2.5  # several looks at the file, and the time that it must be quiet


def newest(renderer):
    """The newest image."""
    frames = wait_until(lambda: f"an image; it said:\n{renderer.stderr_text()}",
                        lambda: renderer.frames() or check(renderer.alive(), renderer.stderr_text()))
    return renderer.picture(frames[-1])


def wait_picture(renderer, what, predicate):
    wait_until(lambda: f"{what}; it said:\n{renderer.stderr_text()}", lambda: predicate(newest(renderer)))


def replace(path, data):
    """Writes beside the file and renames, as editors do."""
    with open(path + ".new", "wb") as file:
        file.write(data)
    os.replace(path + ".new", path)


def overwrite(path, data):
    with open(path, "wb") as file:
        file.write(data)


def next_version(test):
    """The squares in another order and place, and with one more node before them."""
    squares = {"more": ((1, 1, 1), -30), "blue": SQUARES["blue"], "green": SQUARES["green"], "red": SQUARES["red"]}
    write_scene(test.path("next.glb"), squares, place=OTHER_PLACE)
    with open(test.path("next.glb"), "rb") as file:
        return file.read()


def broken_then_whole(test):
    scene = test.path("shown.glb")
    write_scene(scene)
    uri = test.fresh_uri("shm")
    renderer = test.renderer("--watch", "on", listen=[uri], scene=scene)
    publisher = test.publisher(uri)
    publisher.do("publish 3")
    publisher.wait_status("the frame", lambda s: s["acked"] == 3)
    wait_picture(renderer, "the stream", lambda picture: picture.place_of_square("red") not in (None, PLACE_AT_REST))
    data = next_version(test)

    for _ in range(2):  # the same contents are reported once
        overwrite(scene, data[:len(data) // 2])
        renderer.wait_err("warning: the file has changed, but the scene shown before stays: .*shown.glb")
        time.sleep(SETTLED_S)
    check(sum("scene shown before stays" in line for line in renderer.err) == 1, renderer.stderr_text())
    picture = newest(renderer)
    expect_square(picture, "green", PLACE_AT_REST, "after a broken version")
    expect_square(picture, "red", place_of(3), "after a broken version")

    replace(scene, data)
    renderer.wait_err("reloaded .*shown.glb")
    wait_picture(renderer, "the next version", lambda picture: picture.place_of_square("green") not in (None, PLACE_AT_REST))
    picture = newest(renderer)
    expect_square(picture, "green", OTHER_PLACE, "after the reload")
    expect_square(picture, "red", place_of(3), "its stream goes on")
    publisher.do("publish 1")
    publisher.wait_status("the next frame", lambda s: s["acked"] == 4)
    wait_picture(renderer, "the next frame", lambda picture: abs((picture.place_of_square("red") or 0) - place_of(4)) < 0.6)

    # Written in pieces, slower than the renderer looks: nothing is shown before the end.
    write_scene(test.path("last.glb"), place=OTHER_PLACE + 40)
    with open(test.path("last.glb"), "rb") as file:
        last = file.read()
    with open(scene, "wb") as file:
        for at in range(0, len(last), len(last) // 8):
            file.write(last[at:at + len(last) // 8])
            file.flush()
            time.sleep(0.15)
    wait_picture(renderer, "the last version",
                 lambda picture: abs((picture.place_of_square("green") or 0) - OTHER_PLACE - 40) < 0.6)
    check(sum("scene shown before stays" in line for line in renderer.err) == 1, renderer.stderr_text())
    publisher.quit()
    renderer.stop()


def mesh_files(test):
    """A mesh file is converted again."""
    def obj(colour):
        corners = ("-1 -1 0", "1 -1 0", "1 1 0", "-1 1 0")
        return "".join(f"v {corner} {colour}\n" for corner in corners).encode() + b"f 1 2 3 4\n"

    def has(picture, channel):
        pixel = picture.pixel(picture.width // 2, picture.height // 2)
        return all(pixel[channel] > 2 * pixel[other] for other in range(3) if other != channel)
    scene = test.path("square.obj")
    overwrite(scene, obj("1 0 0"))
    renderer = test.renderer("--watch", "on", scene=scene)
    wait_picture(renderer, "a red square", lambda picture: has(picture, 0))
    replace(scene, obj("0 1 0"))
    wait_picture(renderer, "a green square", lambda picture: has(picture, 1))
    overwrite(scene, b"f 1 2 3\n")
    renderer.wait_err("scene shown before stays: .*square.obj")
    check(has(newest(renderer), 1), "the square that was there stays")
    renderer.stop()


def unwatched(test):
    """Images of one run are of one scene, unless it is asked for."""
    scene = test.path("shown.glb")
    write_scene(scene)
    renderer = test.renderer(scene=scene)
    newest(renderer)
    replace(scene, next_version(test))
    time.sleep(SETTLED_S)
    expect_square(newest(renderer), "green", PLACE_AT_REST, "without --watch on")
    renderer.stop()


if __name__ == "__main__":
    main({f.__name__: f for f in (broken_then_whole, mesh_files, unwatched)}, ["fire3dv", "publisher"], plain_images=True)
