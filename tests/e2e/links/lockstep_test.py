#!/usr/bin/env python3
"""End-to-end test of lockstep across renderers: the simulator waits at the first frame that is not shown, and the next
renderer begins with it.
"""
from harness import TRANSPORTS, main, shown
from image_reader import check, expect_square, place_of

FRAMES = 60
FIRST_SHOWS = 12  # images before the first renderer dies
IN_SINK = 6  # finished and acknowledged images that the sink had not yet written when it died


def drawn(renderer):
    return [shown(f, "arm")["sequence"] for f in renderer.frames() if shown(f, "arm")]


def outlives_its_renderer(test, transport):
    uri = test.fresh_uri(transport)
    publisher = test.publisher(uri)
    first = test.renderer("--lockstep", listen=[uri])
    publisher.send(f"lockstep {FRAMES}")
    first.wait_frame("some images", lambda f: shown(f, "arm") and shown(f, "arm")["sequence"] >= FIRST_SHOWS)
    first.kill()
    by_first = drawn(first)
    check(by_first == list(range(1, len(by_first) + 1)), f"not each frame once and in order: {by_first}")
    check(len(by_first) < FRAMES, "the first renderer has shown all: nothing was interrupted")
    check(publisher.alive() and not publisher.out, "the simulator did not wait")

    second = test.renderer("--lockstep", listen=[uri])
    status = publisher.answer("lockstep")
    check(status["acked"] == status["sequence"] == FRAMES, f"not all are acknowledged: {status}")
    frame = second.wait_frame("the last", lambda f: shown(f, "arm") and shown(f, "arm")["sequence"] == FRAMES)
    by_second = drawn(second)
    check(by_second == list(range(by_second[0], FRAMES + 1)), f"not each frame once and in order: {by_second}")
    # A link that still holds older frames also delivers those to the second renderer.
    check(by_second[0] <= by_first[-1] + 1 + IN_SINK, f"frames between {by_first[-1]} and {by_second[0]} were passed over")
    expect_square(second.picture(frame), "red", place_of(FRAMES), frame["file"])
    publisher.quit()
    second.stop()


if __name__ == "__main__":
    main({f"{transport}_outlives_its_renderer": lambda test, t=transport: outlives_its_renderer(test, t)
          for transport in TRANSPORTS}, ["fire3dv", "publisher"], plain_images=True)
