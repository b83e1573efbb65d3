"""Small OpenEXR files: channels R, G and B of halves, ZIP-compressed, without metadata. Reads what it writes."""
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


def _expanded(packed, size):
    if len(packed) == size:
        return packed
    split = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
    split[1:] -= 128
    split = np.cumsum(split).astype(np.uint8)
    data = np.empty(size, np.uint8)
    data[0::2], data[1::2] = split[:(size + 1) // 2], split[(size + 1) // 2:]
    return data.tobytes()


def read(path):
    """Float array of rows x columns x RGB of a file that write() made."""
    with open(path, "rb") as file:
        data = file.read()
    at = data.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    width, height = (edge + 1 for edge in struct.unpack_from("<2i", data, at + 8))
    at = data.index(b"screenWindowWidth\0float\0") + len(b"screenWindowWidth\0float\0") + 9  # length, value, end of header
    pixels = np.empty((height, width, 3), np.float32)
    for offset, in struct.iter_unpack("<Q", data[at:at + 8 * -(-height // ROWS)]):
        top, length = struct.unpack_from("<ii", data, offset)
        rows = min(ROWS, height - top)
        halves = np.frombuffer(_expanded(data[offset + 8:offset + 8 + length], rows * width * 6), "<f2")
        pixels[top:top + rows] = halves.reshape(rows, 3, width).transpose(0, 2, 1)[..., ::-1]
    return pixels
