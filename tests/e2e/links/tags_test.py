#!/usr/bin/env python3
"""End-to-end test of frame tags: the tag of each image is the pose frame in its pixels; --stats has one row per image."""
import csv

from harness import TRANSPORTS, main, shown
from image_reader import check, expect_square, place_of

FRAMES = 12
SIM_STEP_NS = 10_000_000


def tags_in_lockstep(test, transport):
    """Each pose frame is drawn once, in order; the sequence in the PNG text equals that of the pixels."""
    uri = test.fresh_uri(transport)
    stats = test.path("stats.csv")
    renderer = test.renderer("--lockstep", "--exit-when-done", "--stats", stats, listen=[uri])
    publisher = test.publisher(uri)
    status = publisher.do(f"lockstep {FRAMES}")
    check(status["acked"] == FRAMES, f"not all are acknowledged: {status}")
    publisher.quit()
    renderer.expect_exit(0)

    frames = renderer.frames()
    drawn = [f for f in frames if f["streams"]]
    check([shown(f, "arm")["sequence"] for f in drawn] == list(range(1, FRAMES + 1)),
          f"not each frame once and in order: {[f['streams'] for f in drawn]}")
    check([f["frame"] for f in frames] == list(range(len(frames))), "frames.jsonl leaves an image out")
    rows = set()
    for frame in drawn:
        sequence = shown(frame, "arm")["sequence"]
        picture = renderer.picture(frame)  # checks its text chunks against frames.jsonl
        check(picture.text["Stream"] == "arm" and picture.text["Sequence"] == str(sequence)
              and picture.text["SimTimeNs"] == str(sequence * SIM_STEP_NS)
              and picture.text["Epoch"] == status["epoch"], f"{frame['file']} says {picture.text}")
        check(picture.text["Camera"] == frame["camera"] == "front", f"{frame['file']}: the camera is {picture.text}")
        check((picture.width, picture.height) == (frame["width"], frame["height"]) == (160, 90), "the size is wrong")
        expect_square(picture, "red", place_of(sequence), frame["file"])
        rows.add(tuple(picture.rows))
    check(len(rows) == FRAMES, f"only {len(rows)} different pictures of {FRAMES}")
    check_stats(stats, frames)


def check_stats(path, frames):
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    check([int(row["frame"]) for row in rows] == [f["frame"] for f in frames],
          f"--stats has rows of {[row['frame'] for row in rows]} for {len(frames)} images")
    for row, frame in zip(rows, frames):
        passes = [key for key in row if key.endswith("_ms") and key not in ("frame_ms", "cpu_ms", "pose_age_ms", "gpu_ms")]
        check({"poses_ms", "forward_ms", "post_ms"} <= set(passes), f"columns are {list(row)}")
        check(None not in row and None not in row.values(), f"a row is of another length: {row}")
        check(0 < float(row["cpu_ms"]) <= float(row["frame_ms"]), f"frame_ms is not all of cpu_ms: {row}")
        check(float(row["gpu_ms"]) > 0 and all(0 <= float(row[p]) <= float(row["gpu_ms"]) for p in passes), f"{row}")
        check((row["pose_age_ms"] != "") == bool(frame["streams"]), f"a pose age without a pose, or none with one: {row}")
        check(row["pose_age_ms"] == "" or float(row["pose_age_ms"]) > 0, f"{row}")


def tags_while_streaming(test, transport):
    """Without lockstep the tags match the pixels, too, with images in flight and poses that never rest."""
    uri = test.fresh_uri(transport)
    renderer = test.renderer("--exit-when-done", listen=[uri])
    publisher = test.publisher(uri, nodes=["red", "green"])
    publisher.do("stream 300")
    renderer.wait_frame("15 images", lambda f: f["frame"] >= 15 and
                        sum(1 for g in renderer.frames() if g["streams"]) >= 15)
    publisher.quit()
    renderer.expect_exit(0)
    for frame in [f for f in renderer.frames() if shown(f, "arm")][:40]:
        picture = renderer.picture(frame)
        for square in ("red", "green"):
            expect_square(picture, square, place_of(shown(frame, "arm")["sequence"]), frame["file"])


def tags_of_two_streams(test, transport):
    uris = [test.fresh_uri(transport)] + ([test.fresh_uri(transport)] if transport == "shm" else [])
    renderer = test.renderer(listen=uris)
    for uri, name, node in ((uris[0], 'a "quoted" näme', "red"), (uris[-1], "b", "green")):
        test.publisher(uri, name=name, nodes=[node]).do("stream 90")
    frame = renderer.wait_frame("both", lambda f: len(f["streams"]) == 2)
    picture = renderer.picture(frame)
    check({picture.text["Stream.0"], picture.text["Stream.1"]} == {'a "quoted" näme', "b"}, f"{picture.text}")
    expect_square(picture, "green", place_of(shown(frame, "b")["sequence"]), frame["file"])
    renderer.stop()


if __name__ == "__main__":
    main({f"{transport}_{run.__name__}": lambda test, t=transport, r=run: r(test, t)
          for transport in TRANSPORTS for run in (tags_in_lockstep, tags_while_streaming, tags_of_two_streams)},
         ["fire3dv", "publisher"], plain_images=True)
