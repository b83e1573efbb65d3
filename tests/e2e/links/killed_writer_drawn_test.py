#!/usr/bin/env python3
"""End-to-end test of simulators killed at random moments: the renderer goes on, and each image shows one whole frame."""
import random
import time

from harness import main, shown
from image_reader import SQUARES, check, expect_square, place_of

RUNS = 12


def shm_killed(test):
    uri = test.fresh_uri("shm")
    renderer = test.renderer("--play", "latest", listen=[uri])
    renderer.uris()
    generator = random.Random(20262)
    after, epochs = -1, []
    for _ in range(RUNS):
        publisher = test.publisher(uri, nodes=list(SQUARES))
        epoch = publisher.do("stream 2000")["epoch"]
        frame = renderer.wait_frame(f"an image of run {len(epochs)}",
                                    lambda f, e=epoch: shown(f, "arm") and shown(f, "arm")["epoch"] == e, after)
        time.sleep(generator.uniform(0, 0.05))
        publisher.kill()
        after, epochs = frame["frame"], epochs + [epoch]
    at_rest = renderer.wait_frame("the nodes to be given back", lambda f: not f["streams"], after)
    renderer.stop()
    frames = renderer.frames()
    check([f["frame"] for f in frames] == list(range(len(frames))), "an image is missing")
    drawn, last = [], None
    for frame in frames:
        tag = shown(frame, "arm")
        if tag is None:
            continue
        if not drawn or drawn[-1] != tag["epoch"]:
            drawn.append(tag["epoch"])
            last = 0
        check(tag["sequence"] >= last, f"{frame} shows an older frame than the image before")
        last = tag["sequence"]
    check(drawn == epochs, f"drawn were {drawn}, published {epochs}")
    # Reads back the images around each change and some between; each frame defines the place of all three
    # squares.
    looked_at = [f for f in frames if shown(f, "arm")][::max(1, len(frames) // 100)]
    for frame in looked_at:
        picture = renderer.picture(frame)
        for square in SQUARES:
            expect_square(picture, square, place_of(shown(frame, "arm")["sequence"]), frame["file"])
    check(at_rest["frame"] > after and len(looked_at) >= RUNS, f"only {len(looked_at)} images were looked at")


if __name__ == "__main__":
    main({"shm_killed": shm_killed}, ["fire3dv", "publisher"], plain_images=True)
