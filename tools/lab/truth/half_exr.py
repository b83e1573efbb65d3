"""Writer of small OpenEXR files: channels R, G and B of halves, ZIP-compressed, without metadata."""
import struct
import zlib

import numpy as np

ROWS = 16  # of a block of ZIP compression


def _attribute(name, kind, value):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def _compressed(raw):
    data = np.frombuffer(raw, np.uint8)
    split = np.concatenate([data[0::2], data[1::2]]).astype(np.int32)
    split[1:] = (split[1:] - split[:-1] + 128) & 255
    packed = zlib.compress(split.astype(np.uint8).tobytes(), 9)
    return packed if len(packed) < len(raw) else raw


def write(path, pixels):
    """pixels: float array of rows x columns x RGB, the top row first. Values are rounded to the nearest half."""
    halves = np.asarray(pixels, np.float32).astype("<f2")
    height, width = halves.shape[:2]
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(name + b"\0" + struct.pack("<iB3xii", 1, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    header = b"\x76\x2f\x31\x01" + struct.pack("<i", 2)
    header += _attribute("channels", "chlist", channels)
    header += _attribute("compression", "compression", b"\x03")
    header += _attribute("dataWindow", "box2i", window) + _attribute("displayWindow", "box2i", window)
    header += _attribute("lineOrder", "lineOrder", b"\0")
    header += _attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += _attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += _attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    blocks = []
    for top in range(0, height, ROWS):
        rows = halves[top:top + ROWS]
        data = _compressed(b"".join(row[:, channel].tobytes() for row in rows for channel in (2, 1, 0)))
        blocks.append(struct.pack("<ii", top, len(data)) + data)
    offset = len(header) + 8 * len(blocks)
    table = b""
    for block in blocks:
        table += struct.pack("<Q", offset)
        offset += len(block)
    with open(path, "wb") as file:
        file.write(header + table + b"".join(blocks))
