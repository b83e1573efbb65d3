"""Helpers common to the Python examples: options, views, PNG files, error messages."""
import argparse
import math
import struct
import sys
import zlib

import numpy as np

import fire3dv

MOST_PIXELS_A_SIDE = 8192


def whole(text):
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at most 9 digits")
    return int(text)


def count(text):
    value = whole(text)
    if value == 0:
        raise argparse.ArgumentTypeError("0 is too few")
    return value


def size(text):
    """Width and height."""
    sides = text.split("x")
    if len(sides) != 2 or not all(s.isdecimal() and len(s) < 5 and 1 <= int(s) <= MOST_PIXELS_A_SIDE for s in sides):
        raise argparse.ArgumentTypeError(f"{text!r} is not a size such as 640x480; sides are 1 to {MOST_PIXELS_A_SIDE} pixels")
    return int(sides[0]), int(sides[1])


def number(text):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number")
    return value


def positive(text):
    value = number(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not above 0")
    return value


def place(text):
    """Three coordinates in metres."""
    parts = text.split(",")
    if len(parts) != 3:
        raise argparse.ArgumentTypeError(f"{text!r} is not a position such as 0,0.5,0")
    return np.array([number(part) for part in parts])


def expect(is_so, sentence):
    """Ends the program if a received value differs from the requested one."""
    if not is_so:
        raise SystemExit(f"error: {sentence}")


def run(main):
    """main(), whose errors of the renderer, the network and the disk end the program with a sentence."""
    try:
        main()
    except (fire3dv.Error, OSError) as error:
        sys.exit(f"error: {error}")


def looking(eye, target):
    """world_from_camera or world_from_light, (3, 4): along its -Z, +Y is up."""
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross([0, 1, 0], back)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(back, right), back, eye])


def png_file(color):
    """Contents of a PNG file. color: (height, width, 3) uint8."""
    height, width, _ = color.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), color.reshape(height, -1)], axis=1)  # filter type 0 (none)
                                                                                                 # per row

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(b"IEND", b""))


def write_png(path, color):
    with open(path, "wb") as file:
        file.write(png_file(color))
