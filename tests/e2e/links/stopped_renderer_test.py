#!/usr/bin/env python3
"""End-to-end test of a stopped renderer: 10,000 publish calls return, and the renderer then shows the newest frame."""
import signal

from harness import TRANSPORTS, main, shown
from image_reader import check, expect_square, place_of

FRAMES = 10000


def stopped_renderer(test, transport):
    uri = test.fresh_uri(transport)
    renderer = test.renderer("--exit-when-done", listen=[uri])
    publisher = test.publisher(uri)
    publisher.do("publish 1")
    frame = renderer.wait_frame("the first frame", lambda f: shown(f, "arm"))
    renderer.signal(signal.SIGSTOP)
    status = publisher.do(f"publish {FRAMES}")
    check(status["calls"] == status["published"] == status["sequence"] == FRAMES + 1, f"not all are published: {status}")
    check(status["acked"] <= 1, f"a stopped renderer cannot have shown more: {status}")
    renderer.signal(signal.SIGCONT)
    frame = renderer.wait_frame("the newest frame", lambda f: shown(f, "arm") and
                                shown(f, "arm")["sequence"] == FRAMES + 1, frame["frame"])
    picture = renderer.picture(frame)
    check(picture.text["Sequence"] == str(FRAMES + 1), f"the PNG says {picture.text}")
    expect_square(picture, "red", place_of(FRAMES + 1), "the newest frame")
    status = publisher.wait_status("the newest frame to be acknowledged", lambda s: s["acked"] == FRAMES + 1)
    drawn = {shown(f, "arm")["sequence"] for f in renderer.frames() if shown(f, "arm")}
    check(len(drawn) < FRAMES // 10, f"{len(drawn)} frames were drawn: the newest did not overtake the others")
    publisher.quit()
    renderer.expect_exit(0)


def slow_renderer(test, transport):
    """Far more frames than a renderer can draw: the shown frame is never old and never goes back."""
    uri = test.fresh_uri(transport)
    renderer = test.renderer("--exit-when-done", listen=[uri])
    publisher = test.publisher(uri)
    publisher.do("stream 2000")
    renderer.wait_frame("a frame", lambda f: shown(f, "arm"))
    for _ in range(5):
        published = publisher.do("status")["sequence"]
        publisher.do("stream 2000")
        renderer.wait_frame("a frame that is not old", lambda f: shown(f, "arm") and
                            shown(f, "arm")["sequence"] >= published)
    publisher.quit()
    renderer.expect_exit(0)
    drawn = [shown(f, "arm")["sequence"] for f in renderer.frames() if shown(f, "arm")]
    check(drawn == sorted(drawn), f"pictures go back in time: {drawn}")


if __name__ == "__main__":
    main({f"{transport}_{run.__name__}": lambda test, t=transport, r=run: r(test, t)
          for transport in TRANSPORTS for run in (stopped_renderer, slow_renderer)}, ["fire3dv", "publisher"], plain_images=True)
