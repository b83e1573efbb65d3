#!/usr/bin/env python3
"""End-to-end test of the docks of the window with real X input: the image fills the rectangle that panels leave."""
import glob
import os

from harness import main, wait_until
from image_reader import check, ranges_about, ranges_of, read_png, write_scene
from screen import on_a_screen

WINDOW = (640, 400)
BACKGROUND = (32, 64, 128)  # no panel has this colour


def uncovered(picture):
    """Returns the bounds of the background."""
    return picture.box_of(ranges_about(BACKGROUND, 1))


def centre_of_square(picture, name):
    box = picture.box_of(ranges_of(name))
    return box and ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2)


def open_window(test, screen, size=WINDOW):
    scene = test.path("squares.glb")
    write_scene(scene)
    renderer = test.viewer(scene, "--background", "%02x%02x%02x" % BACKGROUND, "--camera", "auto", "--screenshots",
                           test.path("taken"), env=screen.env, size=size)
    window = screen.window(renderer)
    wait_until("an image between the panels", lambda: uncovered(screen.picture(window)))
    return renderer, window, settled(screen, window)


def settled(screen, window):
    """Returns the uncovered rectangle once two screenshots agree."""
    last = [None]

    def same():
        before, last[0] = last[0], uncovered(screen.picture(window))
        return last[0] and before == last[0]
    wait_until("a layout that stays", same)
    return last[0]


def is_centred(screen, window, name, box):
    """The square is seen from the side, so that its bounds are not quite about its centre."""
    centre = centre_of_square(screen.picture(window), name)
    return centre and all(abs(centre[i] - (box[i] + box[i + 2]) / 2) < 0.06 * (box[i + 2] - box[i]) for i in (0, 1))


def image_beside_panels(test, screen):
    """F centres the clicked body in the uncovered rectangle; a screenshot has its size; Tab gives the image the window."""
    renderer, window, box = open_window(test, screen)
    check(box[0] > 150 and box[2] < WINDOW[0] - 150 and box[3] < WINDOW[1] - 20, f"panels leave {box}")
    x, y = centre_of_square(screen.picture(window), "green")
    screen.click(window, int(x), int(y))
    screen.wait_outline(window, (box[0], box[2] - box[0]))
    screen.key("f")
    wait_until("green in the middle of the rectangle", lambda: is_centred(screen, window, "green", box))
    screen.key("p")
    path = renderer.wait_err(r"screenshot (.*\.png)").group(1)
    taken = read_png(path)
    check((taken.width, taken.height) == (box[2] - box[0], box[3] - box[1]), f"{taken.width}x{taken.height} of {box}")
    screen.key("Tab")
    whole = (0, 0, *WINDOW)
    wait_until("an image in the whole window", lambda: uncovered(screen.picture(window)) == whole)
    screen.key("f")
    wait_until("green in the middle of the window", lambda: is_centred(screen, window, "green", whole))
    screen.x11.close(window)
    renderer.expect_exit(0)


def splitters(test, screen):
    """A splitter follows the mouse, its handle folds the dock, and both are kept for the next run."""
    renderer, window, box = open_window(test, screen)
    screen.press(window, box[2] + 3, 60)
    for x in range(box[2] + 3, box[2] - 38, -5):  # into the image: the column is at its limit already
        screen.move(window, x, 60)
    for x in range(box[2] - 37, box[2] + 10, 3):
        screen.move(window, x, 60)
    screen.release()
    wait_until("a narrower right column", lambda: (uncovered(screen.picture(window)) or box)[2] > box[2])
    moved = settled(screen, window)  # all motions of the pointer have arrived
    check(moved[:2] == box[:2], f"{moved}, not {box}")
    # The handle is in the middle of the splitter.
    screen.click(window, box[0] - 3, WINDOW[1] // 2)
    folded = wait_until("a folded left column", lambda: (lambda now: now and now[0] < 20 and now)(
        uncovered(screen.picture(window))))
    screen.x11.close(window)
    renderer.expect_exit(0)
    renderer, window, again = open_window(test, screen)
    check(again == settled(screen, window) and again[0] == folded[0] and abs(again[2] - moved[2]) < 2, f"{again} after {folded}")
    screen.click(window, again[0] - 5, WINDOW[1] // 2)
    wait_until("the left column again", lambda: (uncovered(screen.picture(window)) or (0,))[0] == box[0])
    screen.x11.close(window)
    renderer.expect_exit(0)


def videos(test, screen):
    """A video goes on while panels are hidden and shown."""
    renderer, window, box = open_window(test, screen)
    screen.key("v")
    renderer.wait_err(r"recording .*\.mp4")
    screen.key("Tab")
    wait_until("no panels beside the image", lambda: screen.picture(window).pixel(4, 4) == (0, 0, 0))
    check(uncovered(screen.picture(window)) == box, "the image of the video moved")
    screen.key("v")
    renderer.wait_err(r"video .*\.mp4")
    check(not renderer.find_err("the video ends"), renderer.stderr_text())
    check(all(os.path.getsize(path) for path in glob.glob(test.path("taken/*.mp4"))), "the video is empty")
    wait_until("an image in the whole window", lambda: uncovered(screen.picture(window)) == (0, 0, *WINDOW))
    screen.x11.close(window)
    renderer.expect_exit(0)


def double_scale(test, screen):
    """On a display of scale 2 the image keeps its share of the window, and F1 lays help over it."""
    size = (1280, 720)
    renderer, window, box = open_window(test, screen, size)
    check(box[2] - box[0] >= 0.39 * size[0] and box[3] - box[1] >= 0.59 * size[1], f"panels leave {box}")
    check(box[0] > 300, f"panels have the size of scale 1: {box}")
    screen.key("F1")
    # Its two columns are wider than the image.
    wait_until("help over the image", lambda: all(BACKGROUND not in {screen.picture(window).pixel(x, 360)}
                                                  for x in range(box[0], box[2], 40)))
    screen.key("F1")
    wait_until("the image again", lambda: uncovered(screen.picture(window)) == box)
    screen.x11.close(window)
    renderer.expect_exit(0)


CASES = {f.__name__: on_a_screen(f) for f in (image_beside_panels, splitters, videos)}
CASES["double_scale"] = on_a_screen(double_scale, size=(1280, 800), dpi=192)

if __name__ == "__main__":
    main(CASES, ["fire3dv"], plain_images=True)
