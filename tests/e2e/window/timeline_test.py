#!/usr/bin/env python3
"""End-to-end test of the timeline keys and of the variants of a window, with real X input: Space, Left, Right, comma and
period drive animations and replays; the choice of a material variant is shown.
"""
import os
import time

from glb_edit import add_slide, add_variants
from harness import main, wait_until
from image_reader import check, place_of, ranges_of
from screen import SIZE, all_squares, on_a_screen

FIRST_PLACE, LAST_PLACE, DURATION_S = -120.0, 120.0, 8.0
UNITS_PER_S = (LAST_PLACE - FIRST_PLACE) / DURATION_S


def place(screen, window, name="red"):
    return screen.picture(window).place_of_square(name)


REST_S = 1.0  # longer than a frame takes on a busy machine


def rests(screen, window):
    """Returns the place of red once it has not moved for REST_S."""
    last = [place(screen, window), time.monotonic()]

    def same():
        at = place(screen, window)
        if at != last[0]:
            last[:] = [at, time.monotonic()]
        return time.monotonic() - last[1] > REST_S
    wait_until("red at rest", same)
    return last[0]


def moves(screen, window):
    at = place(screen, window)
    wait_until("red to move", lambda: abs((place(screen, window) or at) - at) > 1)


def goes_to(screen, window, key, wanted, tolerance=1.1):
    screen.key(key)
    wait_until(lambda: f"{key} to show red at {wanted}, not at {place(screen, window)}",
               lambda: abs((place(screen, window) or 1e9) - wanted) < tolerance)
    return rests(screen, window)


def animations(test, screen):
    """Space pauses and plays, period and comma step by 1/30 s, the arrows skip a second."""
    scene = add_slide(test.scene, test.path("sliding.glb"), FIRST_PLACE, LAST_PLACE, DURATION_S)
    renderer = test.viewer(scene, "--gui", "off", "--animate", env=screen.env, size=SIZE)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    moves(screen, window)
    screen.key("space")
    at = rests(screen, window)
    tolerance = 8  # a square at the edge of the image is cut off: the centre of what is left is further inside
    while tolerance > 2 or not -45 < at < 45:  # the image ends at 80: room for a skip in both directions
        key, by = ("Right", UNITS_PER_S) if at < 0 else ("Left", -UNITS_PER_S)
        at = goes_to(screen, window, key, at + by, tolerance)
        tolerance = 1.1
    check(abs(goes_to(screen, window, "Right", at + UNITS_PER_S) - at - UNITS_PER_S) < 1.1, "one second forwards")
    check(abs(goes_to(screen, window, "Left", at) - at) < 1.1, "one second back")
    step = UNITS_PER_S / 30
    screen.key(*["period"] * 5)
    goes_to(screen, window, "period", at + 6 * step)
    screen.key(*["comma"] * 11)
    goes_to(screen, window, "comma", at - 6 * step)
    screen.key("space")
    moves(screen, window)
    screen.x11.close(window)
    renderer.expect_exit(0)


def replays(test, screen):
    """At the end of a recording comma shows the frame before, period the one after, and Space plays it again."""
    frames, path, uri = 12, test.path("live.mcap"), test.fresh_uri("tcp")
    publisher = test.publisher(uri)
    live = test.renderer("--lockstep", "--exit-when-done", "--record", path, listen=[uri])
    publisher.do(f"lockstep {frames}")
    publisher.quit()
    live.expect_exit()
    renderer = test.viewer(test.scene, "--gui", "off", "--replay", path, env=screen.env, size=SIZE)
    window = screen.window(renderer)

    def shows(sequence):
        wait_until(lambda: f"frame {sequence}, not red at {place(screen, window)}",
                   lambda: abs((place(screen, window) or 1e9) - place_of(sequence)) < 0.6)
    shows(frames)
    for key, sequence in (("comma", frames - 1), ("comma", frames - 2), ("comma", frames - 3), ("period", frames - 2)):
        screen.key(key)
        shows(sequence)
        rests(screen, window)
    screen.key("space")
    shows(frames)
    screen.x11.close(window)
    renderer.expect_exit(0)


# Positions of the controls in a window of this size, with only the materials panel open.
PANELS_SIZE = (640, 400)
COMBO, FIRST_ROW_Y, ROW_PX, COLUMN_X = (590, 168), 191, 17.5, 460


def variants(test, screen):
    """Choosing a variant in the panel shows its materials. The stream goes on: its body stays where it was put."""
    scene = add_variants(test.scene, test.path("variants.glb"), {"like green": "green", "like blue": "blue"})
    arrangement = test.path("config/fire3dv/window.conf")
    os.makedirs(os.path.dirname(arrangement))
    with open(arrangement, "w", encoding="ascii") as file:
        for panel in ("scene", "node", "cameras", "frame", "streams", "lights", "render", "log"):
            file.write(f"{panel} = closed\n")
        file.write("materials = open\nleft-dock = folded\n")
    uri = test.fresh_uri("shm")
    renderer = test.viewer(scene, "--listen", uri, "--variant", "like blue", "--motion-quality", "full", env=screen.env,
                           size=PANELS_SIZE)
    window = screen.window(renderer)
    publisher = test.publisher(uri)

    def columns_of(colour):
        """Columns of the image with this colour: at rest all bodies are outside of it."""
        row = screen.picture(window).matches(ranges_of(colour), 20, 440)[58]  # of red's body
        return [20 + x for x, is_wanted in enumerate(row) if is_wanted]
    wait_until("an image", lambda: screen.picture(window).pixel(200, 200) != (0, 0, 0))
    publisher.do("publish 20")
    place = wait_until("a blue body", lambda: columns_of("blue"))

    def choose(row, colour):
        def column():
            return screen.picture(window).columns(COLUMN_X, PANELS_SIZE[0] - COLUMN_X).rows
        screen.move(window, *COMBO)
        time.sleep(0.5)
        closed = column()
        screen.click_here()
        wait_until("a list of variants", lambda: column() != closed)
        screen.click(window, COMBO[0], int(FIRST_ROW_Y + ROW_PX * row))
        wait_until(f"{colour} where the stream put it", lambda: columns_of(colour) == place)
    choose(1, "green")
    choose(2, "blue")
    choose(0, "red")
    publisher.do("publish 4")
    wait_until("a new frame of the stream", lambda: (lambda now: now and now[0] > place[0] + 20)(columns_of("red")))
    check(not renderer.find_err("error:|stream .*(lost|ended)"), renderer.stderr_text())
    screen.x11.close(window)
    wait_until("the end, or a refusal", lambda: not renderer.alive() or renderer.find_err("close again to discard"))
    if renderer.alive():
        screen.x11.close(window)  # the variant is an edit
    renderer.expect_exit(0)
    publisher.quit()


CASES = {f.__name__: on_a_screen(f) for f in (animations, replays, variants)}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "publisher"], plain_images=True)
