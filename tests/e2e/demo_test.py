#!/usr/bin/env python3
"""Runs tools/demo.sh over one transport and holds what it leaves against what it promises.

  demo_test.py DEMO_SH BIN_DIR shm|tcp|udp
"""
import json
import os
import struct
import subprocess
import sys
import tempfile

SECONDS = 2
IMAGES = 15 * SECONDS + 1
SIZE = (160, 90)
LEFT_FROM_BEFORE = {"frame_000999.png": "", "frames.jsonl": "{}\n", "holiday.png": "not the demo's"}


def check(condition, text):
    if not condition:
        sys.exit(f"demo_test: {text}")


def png_size_and_text(path):
    """Returns width, height, and the tEXt chunks."""
    with open(path, "rb") as file:
        data = file.read()
    check(data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG")
    at, size, text = 8, None, {}
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            size = struct.unpack_from(">II", body)
        if kind == b"tEXt":
            keyword, value = body.split(b"\0", 1)
            text[keyword.decode()] = value.decode("latin-1")
        at += 12 + length
    return size, text


def run_demo(script, bin_dir, transport, out, seconds):
    result = subprocess.run(["bash", script, "--transport", transport, "--seconds", str(seconds), "--size",
                             f"{SIZE[0]}x{SIZE[1]}", "--out", out], env={**os.environ, "FIRE3DV_DEMO_BIN": bin_dir},
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    check(result.returncode == 0, f"demo.sh ended with {result.returncode}:\n{result.stdout}")
    return result.stdout


def images_of_stream(out):
    with open(os.path.join(out, "frames.jsonl"), encoding="utf-8") as log:
        frames = [json.loads(line) for line in log]
    return [frame for frame in frames if frame["streams"]]


def main():
    check(len(sys.argv) == 4, __doc__)
    script, bin_dir, transport = sys.argv[1:]
    with tempfile.TemporaryDirectory(prefix="fire3dv-demo-") as folder:
        out = os.path.join(folder, "out with a blank")
        os.mkdir(out)
        for name, content in LEFT_FROM_BEFORE.items():
            with open(os.path.join(out, name), "w", encoding="utf-8") as file:
                file.write(content)
        text = run_demo(script, bin_dir, transport, out, SECONDS)

        check(not os.path.exists(os.path.join(out, "frame_000999.png")), "an image of an earlier run is left")
        check(os.path.exists(os.path.join(out, "holiday.png")), "it removed what is not its own")
        frames = images_of_stream(out)
        check([frame["streams"][0]["sequence"] for frame in frames] == list(range(1, IMAGES + 1)),
              f"not each of {IMAGES} pose frames is drawn once: {[f['streams'][0]['sequence'] for f in frames]}")
        for number, frame in enumerate(frames):
            stream = frame["streams"][0]
            check(abs(stream["sim_time_ns"] - number * 1e9 / 15) < 1e5, f"image {number} shows {stream['sim_time_ns']} ns")
            size, chunks = png_size_and_text(os.path.join(out, frame["file"]))
            check(size == SIZE, f"{frame['file']} is {size}")
            check(chunks.get("Stream") == "bullet_arm" and chunks.get("Sequence") == str(stream["sequence"])
                  and chunks.get("SimTimeNs") == str(stream["sim_time_ns"]), f"{frame['file']} says {chunks}")
        contents = {open(os.path.join(out, frame["file"]), "rb").read() for frame in frames}
        check(len(contents) == len(frames), "images are the same")

        video = os.path.join(out, "demo.mp4")
        probe = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries",
                                "stream=codec_name,pix_fmt,nb_read_frames", "-of", "json", video],
                               check=True, capture_output=True, text=True).stdout
        stream = json.loads(probe)["streams"][0]
        check(stream["codec_name"] == "h264" and stream["pix_fmt"] == "yuv420p", f"the video is {stream}")
        check(int(stream["nb_read_frames"]) == IMAGES, f"the video has {stream['nb_read_frames']} images")

        check(video in text and os.path.join(out, "frame_000000.png") in text, "it does not say where things are")
        check("pose age" in text, "it does not print the pose age")
        with open(os.path.join(out, "stats.csv"), encoding="utf-8") as stats:
            check(len(stats.readlines()) > IMAGES, "times of some images are not in stats.csv")
    print(f"demo_test: passed over {transport}")


if __name__ == "__main__":
    main()
