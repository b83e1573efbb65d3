"""Scene of the end-to-end tests, and image reading: the position of a square identifies the shown frame."""
import json
import struct
import zlib


class Failure(Exception):
    pass


def check(condition, text):
    if not condition:
        raise Failure(text)


SIZE = (160, 90)

# Squares of the scene, one colour and one row each; a unit is a pixel and (0, 0) is the centre of the image.
SQUARES = {"red": ((1, 0, 0), 30), "green": ((0, 1, 0), 10), "blue": ((0, 0, 1), -10)}
HALF_SQUARE = 4
PLACE_AT_REST = 66.0


def place_of(sequence):
    """Returns the position at which publisher.cpp puts its nodes."""
    return -70.0 + 4.0 * (sequence % 32)


# --- the scene -------------------------------------------------------------------------------------------------------

def write_scene(path, squares=None, sun=False, place=PLACE_AT_REST, away=False):
    """Writes a glb of squares (three by default) before a camera that maps a unit to a pixel; unlit, or lit by a sun.
    away: adds a second camera that sees none of them.
    """
    h = HALF_SQUARE
    binary, views, accessors, meshes, materials, nodes = b"", [], [], [], [], []

    def add(data, accessor):
        nonlocal binary
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        accessors.append({"bufferView": len(views) - 1, **accessor})
        binary += data
        return len(accessors) - 1

    indices = add(struct.pack("<6I", 0, 1, 2, 0, 2, 3), {"componentType": 5125, "count": 6, "type": "SCALAR"})
    for name, (colour, row) in (squares or SQUARES).items():
        corners = [(-h, row - h, 0), (h, row - h, 0), (h, row + h, 0), (-h, row + h, 0)]
        positions = add(b"".join(struct.pack("<3f", *c) for c in corners),
                        {"componentType": 5126, "count": 4, "type": "VEC3",
                         "min": [-h, row - h, 0], "max": [h, row + h, 0]})
        normals = add(struct.pack("<3f", 0, 0, 1) * 4, {"componentType": 5126, "count": 4, "type": "VEC3"})
        materials.append({"name": name, "extensions": {} if sun else {"KHR_materials_unlit": {}},
                          "pbrMetallicRoughness": {"baseColorFactor": [*colour, 1]}})
        meshes.append({"name": name, "primitives": [{"attributes": {"POSITION": positions, "NORMAL": normals},
                                                     "indices": indices, "material": len(materials) - 1}]})
        nodes.append({"name": name, "mesh": len(meshes) - 1, "translation": [place, 0, 0]})
    nodes.append({"name": "front", "camera": 0, "translation": [0, 0, 50]})
    if away:
        nodes.append({"name": "away", "camera": 0, "translation": [0, 10000, 50]})
    lights = {"extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 1}]}}} if sun else {}
    if sun:
        nodes.append({"name": "sun", "extensions": {"KHR_lights_punctual": {"light": 0}}})
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "meshes": meshes, "materials": materials, "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}], "extensionsUsed": ["KHR_lights_punctual" if sun else "KHR_materials_unlit"], **lights,
        "cameras": [{"name": "camera of front", "type": "orthographic",
                     "orthographic": {"xmag": SIZE[0] / 2, "ymag": SIZE[1] / 2, "znear": 1, "zfar": 100}}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


# --- images ----------------------------------------------------------------------------------------------------------

class Picture:
    """Pixels as rows of bytes, 3 a pixel."""

    def __init__(self, width, height, rows, text=None):
        self.width, self.height, self.rows, self.text = width, height, rows, text or {}

    def pixel(self, x, y):
        return tuple(self.rows[y][3 * x:3 * x + 3])

    def columns(self, first, count):
        return Picture(count, self.height, [row[3 * first:3 * (first + count)] for row in self.rows], self.text)

    def matches(self, ranges, first=0, end=None):
        """For each row, one byte a pixel of the columns: 1 where red, green and blue are in their ranges. Fast enough to poll."""
        tables = [bytes(low <= value <= high for value in range(256)) for low, high in ranges]
        width = (self.width if end is None else end) - first
        found = []
        for row in self.rows:
            planes = [int.from_bytes(row[3 * first + i:3 * (first + width):3].translate(tables[i]), "big") for i in range(3)]
            found.append((planes[0] & planes[1] & planes[2]).to_bytes(width, "big"))
        return found

    def box_of(self, ranges, first=0, end=None):
        """Returns left, top, right and bottom of the pixels in these ranges, or None."""
        found = self.matches(ranges, first, end)
        rows = [y for y, row in enumerate(found) if 1 in row]
        if not rows:
            return None
        return (first + min(found[y].find(1) for y in rows), rows[0], first + max(found[y].rfind(1) for y in rows) + 1, rows[-1] + 1)

    def row_of(self, name):
        """Returns the centre of the rows that show this colour, or None."""
        box = self.box_of(ranges_of(name))
        return (box[1] + box[3]) / 2 if box else None

    def place_of_square(self, name):
        """Returns the centre of the square along x in units, or None if it is not in the image."""
        row = self.rows[int((SIZE[1] / 2 - SQUARES[name][1]) * self.height / SIZE[1])]
        box = Picture(self.width, 1, [row]).box_of(ranges_of(name))
        return ((box[0] + box[2]) / 2 - self.width / 2) * SIZE[0] / self.width if box else None


def ranges_of(name, high=200, low=60):
    """Ranges of the channels of a square's colour, as it is drawn."""
    return [(high + 1, 255) if channel else (0, low - 1) for channel in SQUARES[name][0]]


def ranges_about(colour, distance):
    """Ranges of the channels of a colour that differ by less than the distance."""
    return [(channel - distance + 1, channel + distance - 1) for channel in colour]


def png_parts(path):
    """Returns the fields of IHDR, the filtered rows and the texts of a PNG file."""
    with open(path, "rb") as file:
        data = file.read()
    check(data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG")
    at, header, pixels, text = 8, None, b"", {}
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + length]
        check(zlib.crc32(kind + body) == struct.unpack_from(">I", data, at + 8 + length)[0], f"{path}: {kind} is damaged")
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            pixels += body
        elif kind == b"tEXt":
            keyword, value = body.split(b"\0", 1)
            text[keyword.decode()] = value.decode("latin-1")
        elif kind == b"iTXt":
            keyword, rest = body.split(b"\0", 1)
            text[keyword.decode()] = rest[2:].split(b"\0", 2)[2].decode()
        at += 12 + length
    return header, zlib.decompress(pixels), text


def read_png(path):
    header, pixels, text = png_parts(path)
    width, height, depth, colour = header[:4]
    check(depth == 8 and colour in (2, 6) and header[6] == 0, f"{path}: not 8-bit colour: {header}")
    return Picture(width, height, unfilter(pixels, width, height, 3 if colour == 2 else 4), text)


def read_gray_png(path):
    """Returns the rows of a PNG of 16-bit grey as tuples of numbers, and its texts."""
    header, raw, text = png_parts(path)
    width, height, depth, colour = header[:4]
    check((depth, colour, header[6]) == (16, 0, 0), f"{path}: not 16-bit grey: {header}")
    rows = []
    for y in range(height):
        line = raw[y * (2 * width + 1):(y + 1) * (2 * width + 1)]
        check(line[0] == 1, f"{path}: the filter {line[0]}")
        rows.append(struct.unpack(f">{width}H", sums(bytearray(line[1:]), 2)))
    return rows, text


def added(a, b):
    """Sums of bytes, modulo 256."""
    length = len(a)
    low = int.from_bytes(b"\x7f" * length, "little")
    x, y = int.from_bytes(a, "little"), int.from_bytes(b, "little")
    return bytearray((((x & low) + (y & low)) ^ ((x ^ y) & ~low)).to_bytes(length, "little"))


def sums(line, size):
    """Each byte plus all bytes before it of the same channel, modulo 256."""
    step = size
    while step < len(line):
        line = added(line, bytes(step) + line[:-step])
        step *= 2
    return line


def unfilter(raw, width, height, size):
    """Undoes the five PNG filters and drops an alpha channel."""
    stride, rows, above = width * size, [], bytearray(width * size)
    for y in range(height):
        kind = raw[y * (stride + 1)]
        line = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        if kind == 1:  # Sub and Up, which fire3dv writes, as sums of whole rows
            line = sums(line, size)
        elif kind == 2:
            line = added(line, above)
        for i in range(stride if kind > 2 else 0):
            a = line[i - size] if i >= size else 0
            b, c = above[i], above[i - size] if i >= size else 0
            if kind == 3:
                add = (a + b) // 2
            else:
                p = a + b - c
                add = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line[i] = (line[i] + add) & 255
        above = line
        rows.append(bytes(line) if size == 3 else b"".join(line[i:i + 3] for i in range(0, stride, 4)))
    return rows


def expect_square(picture, square, place, what):
    at = picture.place_of_square(square)
    check(at is not None and abs(at - place) < 0.6, f"{what}: {square} is at {at}, not at {place}")
