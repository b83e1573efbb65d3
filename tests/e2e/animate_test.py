#!/usr/bin/env python3
"""End-to-end test of --animate: time advances per image without a stream, follows simulated time with one, and never goes
back.
"""
from glb_edit import add_slide
from harness import main, shown
from image_reader import check, expect_square, place_of

IMAGES_PER_SECOND = 30
FIRST_PLACE, LAST_PLACE, DURATION_S = -60.0, 60.0, 1.0
SIM_STEP_S = 0.01


def place_at(time_s):
    return FIRST_PLACE + (LAST_PLACE - FIRST_PLACE) * (time_s % DURATION_S) / DURATION_S


def sliding_scene(test):
    """Writes the tests' scene with an animation "slide" of the red and the blue square."""
    return add_slide(test.scene, test.path("sliding.glb"), FIRST_PLACE, LAST_PLACE, DURATION_S)


def by_images(test):
    scene = sliding_scene(test)
    rows = []
    for arguments in (["--animate", "slide"], ["--animate"]):
        renderer = test.renderer("--frames", "32", *arguments, scene=scene)
        renderer.wait_err(r"^fire3dv: info: playing animation \"slide\", of 1$")
        renderer.expect_exit(0)
        pictures = [renderer.picture(frame) for frame in renderer.frames()]
        check(len(pictures) == 32, f"{len(pictures)} images")
        for i in (1, 10, 29, 31):  # the last one is in the second loop
            for square in ("red", "blue"):
                expect_square(pictures[i], square, place_at(i / IMAGES_PER_SECOND), f"image {i}")
        expect_square(pictures[10], "green", 66.0, "what is not animated")
        rows.append([picture.rows for picture in pictures])
    check(rows[0] == rows[1], "two runs differ")


def by_simulated_time(test):
    uri = test.fresh_uri("shm")
    renderer = test.renderer("--animate", "0", "--lockstep", "--exit-when-done", listen=[uri], scene=sliding_scene(test))
    publisher = test.publisher(uri)
    publisher.do("lockstep 12")
    publisher.quit()
    renderer.expect_exit(0)
    drawn = [frame for frame in renderer.frames() if frame["streams"]]
    check(len(drawn) == 12, f"{len(drawn)} images")
    for frame in drawn:
        sequence = shown(frame, "arm")["sequence"]
        picture = renderer.picture(frame)
        expect_square(picture, "red", place_of(sequence), f"what the stream drives, in {frame['file']}")
        expect_square(picture, "blue", place_at(sequence * SIM_STEP_S), f"what it does not drive, in {frame['file']}")


if __name__ == "__main__":
    main({"by_images": by_images, "by_simulated_time": by_simulated_time}, ["fire3dv", "publisher"])
