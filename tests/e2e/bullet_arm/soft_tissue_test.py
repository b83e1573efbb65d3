#!/usr/bin/env python3
"""End-to-end test of examples/soft_tissue: images of a phantom that is grasped and cut show vertices and poses of one frame.

The vertices of the square of --frame-code cancel its pose: it stands still in an image where both are of one frame.
"""
import re

from harness import Program, main, shown
from image_reader import check, read_png

GREEN = ((0, 90), (220, 255), (0, 90))
RESULT = r"frames (\d+) vertices (\d+) nodes (\d+); a step [\d.]+ ms of CPU time \(95 %: [\d.]+\), publishing [\d.]+ ms"


def program(test, *arguments):
    return Program(test, "soft_tissue", [test.programs_at["soft_tissue"], *arguments])


def result(run):
    run.expect_exit(0)
    found = re.search(RESULT, "\n".join(run.out))
    check(found, f"{run.out}")
    return [int(text) for text in found.groups()]


def frames(test):
    scene, picture, uri = test.path("tissue.glb"), test.path("tissue.png"), test.fresh_uri("shm")
    program(test, "--write-scene", scene, "--detail", "24", "--frame-code").expect_exit(0)
    renderer = test.renderer("--camera", "camera", "--exposure", "1", listen=[uri], scene=scene, size=(96, 72))
    renderer.uris()
    # The first picture waits for the driver's compiler; the frames of the next run are drawn at once.
    result(program(test, "--to", uri, "--detail", "24", "--seconds", "0.2", "--frame-code", "--picture", picture, "--size", "96", "72"))
    # The square moves with each frame; the cut begins after 2.2 s.
    run = program(test, "--to", uri, "--detail", "24", "--seconds", "4", "--frame-code", "--picture", picture, "--size", "96", "72")
    count, vertices, _ = result(run)
    check(count == 241 and vertices > 700, f"{count} frames, {vertices} vertices")
    drawn = read_png(picture)
    check((drawn.width, drawn.height) == (96, 72) and drawn.box_of(GREEN), f"the picture does not show the scene: {drawn.pixel(10, 10)}")
    place, sequences = None, set()
    for frame in renderer.frames():
        stream = shown(frame, "soft_tissue")
        if not stream or stream["sequence"] == 0 or stream["state"] == "ended":
            continue
        box = renderer.picture(frame).box_of(GREEN)
        if place is None and box is None:
            continue  # before the first frame
        place = place or box
        # One frame moves it by three pixels; rounding in the raster may cost one at its border.
        check(box and max(abs(a - b) for a, b in zip(box, place)) <= 1, f"{frame['file']}, frame {stream['sequence']}: the square is at {box}, not at {place}: its vertices and "
              "its pose are of two frames")
        sequences.add(stream["sequence"])
    check(len(sequences) > 4 and max(sequences) > 150, f"the renderer has shown frames {sorted(sequences)}")
    check(not renderer.find_err("warning: stream"), f"{renderer.stderr_text()}")
    renderer.stop()


def numbers(test):
    """The same steps with and without a renderer; faults of use."""
    first, again = (result(program(test, "--detail", "24", "--seconds", "2.5")) for _ in range(2))
    check(first == again and first[0] == 151, f"{first} {again}")
    for arguments, text in ((["--picture", "a.png"], "--picture: needs --to"), (["--detail", "3"], "--detail")):
        run = program(test, *arguments)
        check(run.wait() == 2 and text in run.stderr_text(), f"{arguments}: {run.stderr_text()}")


if __name__ == "__main__":
    main({"numbers": numbers, "frames": frames}, ["fire3dv", "soft_tissue"], plain_images=True)
