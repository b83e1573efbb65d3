#!/usr/bin/env python3
"""End-to-end test of the timeline keys of a window with real X input: Space, Left, Right, comma and period drive
animations and replays.
"""
from glb_edit import add_slide
from harness import main, wait_until
from image_reader import check, place_of
from screen import SIZE, all_squares, on_a_screen

FIRST_PLACE, LAST_PLACE, DURATION_S = -120.0, 120.0, 8.0
UNITS_PER_S = (LAST_PLACE - FIRST_PLACE) / DURATION_S


def place(screen, window, name="red"):
    return screen.picture(window).place_of_square(name)


def rests(screen, window):
    """Returns the place of red once it no longer moves."""
    last = [None, None, None]

    def same():
        last.pop(0)
        last.append(place(screen, window))
        return last[0] is not None and last[0] == last[1] == last[2]
    wait_until("red at rest", same)
    return last[0]


def moves(screen, window):
    at = place(screen, window)
    wait_until("red to move", lambda: abs((place(screen, window) or at) - at) > 1)


def goes_to(screen, window, key, wanted):
    screen.xdotool("key", key)
    wait_until(lambda: f"{key} to show red at {wanted}, not at {place(screen, window)}",
               lambda: abs((place(screen, window) or 1e9) - wanted) < 1.1)
    return rests(screen, window)


def animations(test, screen):
    """Space pauses and plays, period and comma step by 1/30 s, the arrows skip a second."""
    scene = add_slide(test.scene, test.path("sliding.glb"), FIRST_PLACE, LAST_PLACE, DURATION_S)
    renderer = test.viewer(scene, "--gui", "off", "--animate", env=screen.env, size=SIZE)
    window = screen.window(renderer)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    moves(screen, window)
    screen.xdotool("key", "space")
    at = rests(screen, window)
    while not FIRST_PLACE + 40 < at < LAST_PLACE - 40:  # room for a skip in both directions
        key, by = ("Right", UNITS_PER_S) if at < 0 else ("Left", -UNITS_PER_S)
        at = goes_to(screen, window, key, at + by)
    check(abs(goes_to(screen, window, "Right", at + UNITS_PER_S) - at - UNITS_PER_S) < 1.1, "one second forwards")
    check(abs(goes_to(screen, window, "Left", at) - at) < 1.1, "one second back")
    step = UNITS_PER_S / 30
    screen.xdotool("key", *["period"] * 5)
    goes_to(screen, window, "period", at + 6 * step)
    screen.xdotool("key", *["comma"] * 11)
    goes_to(screen, window, "comma", at - 6 * step)
    screen.xdotool("key", "space")
    moves(screen, window)
    screen.x11.close(int(window))
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
        screen.xdotool("key", key)
        shows(sequence)
        rests(screen, window)
    screen.xdotool("key", "space")
    shows(frames)
    screen.x11.close(int(window))
    renderer.expect_exit(0)


CASES = {f.__name__: on_a_screen(f) for f in (animations, replays)}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "publisher"])
