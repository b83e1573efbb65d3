#!/usr/bin/env python3
"""Reads DIR/frames.jsonl and prints a list for ffmpeg's concat demuxer, in which each image stands for as long as the
simulation stood still behind it. So the video runs in simulated time, however fast or unevenly it was drawn.

  video_list.py DIR > DIR/frames.ffconcat
"""
import json
import os
import sys

LAST_IMAGE_S = 1 / 15


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: video_list.py DIR")
    path = os.path.join(sys.argv[1], "frames.jsonl")
    shots = []  # (simulated time, file) per drawn pose frame
    try:
        with open(path, encoding="utf-8") as log:
            for line in log:
                frame = json.loads(line)
                if not frame["streams"]:
                    continue  # scene at rest, before or after the stream
                sim_time_ns = frame["streams"][0]["sim_time_ns"]
                if not shots or sim_time_ns > shots[-1][0]:
                    shots.append((sim_time_ns, frame["file"]))
    except (OSError, ValueError, KeyError) as fault:
        sys.exit(f"video_list.py: cannot read {path}: {fault}")
    if not shots:
        sys.exit(f"video_list.py: no image in {path} shows a stream")
    print("ffconcat version 1.0")
    for (sim_time_ns, name), following in zip(shots, shots[1:] + [None]):
        duration_s = (following[0] - sim_time_ns) * 1e-9 if following else LAST_IMAGE_S
        print(f"file {name}\nduration {duration_s:.6f}")


if __name__ == "__main__":
    main()
