"""Reader of Parquet files by Python alone, from the documentation of the format (parquet.thrift, Encodings.md): plain values and
RLE levels of uncompressed pages of version 1, as FIRE-3DV writes them."""
import struct

from image_reader import check

BOOLEAN_TRUE, BOOLEAN_FALSE, BYTE, I16, I32, I64, DOUBLE, BINARY, LIST, SET, MAP, STRUCT = range(1, 13)


class Compact:
    """Thrift's compact protocol: structs as dictionaries by field."""

    def __init__(self, data, at=0):
        self.data, self.at = data, at

    def byte(self):
        self.at += 1
        return self.data[self.at - 1]

    def varint(self):
        value = shift = 0
        while True:
            byte = self.byte()
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    def zigzag(self):
        value = self.varint()
        return value >> 1 ^ -(value & 1)

    def value(self, kind):
        if kind in (BOOLEAN_TRUE, BOOLEAN_FALSE):
            return kind == BOOLEAN_TRUE
        if kind in (I16, I32, I64):
            return self.zigzag()
        if kind == BINARY:
            size = self.varint()
            self.at += size
            return bytes(self.data[self.at - size:self.at])
        if kind == LIST:
            head = self.byte()
            count = head >> 4 if head >> 4 != 15 else self.varint()
            return [self.value(head & 15) for _ in range(count)]
        check(kind == STRUCT, f"type {kind}")
        fields, last = {}, 0
        while (head := self.byte()) != 0:
            last = last + (head >> 4) if head >> 4 else self.zigzag()
            fields[last] = self.value(head & 15)
        return fields


def levels(data, at, count, width):
    """Levels of the hybrid of runs and packed groups, with their length in front, and the end."""
    (size,) = struct.unpack_from("<I", data, at)
    reader, end = Compact(data, at + 4), at + 4 + size
    out = []
    while reader.at < end:
        head = reader.varint()
        if head & 1:
            packed = int.from_bytes(data[reader.at:reader.at + (head >> 1) * width], "little")
            out += [packed >> width * i & (1 << width) - 1 for i in range(8 * (head >> 1))]
            reader.at += (head >> 1) * width
        else:
            out += [int.from_bytes(data[reader.at:reader.at + (width + 7) // 8], "little")] * (head >> 1)
            reader.at += (width + 7) // 8
    check(reader.at == end and len(out) >= count, "levels")
    return out[:count], end


def plain(data, at, kind, count):
    if kind == 6:
        texts = []
        for _ in range(count):
            (size,) = struct.unpack_from("<I", data, at)
            texts.append(data[at + 4:at + 4 + size].decode())
            at += 4 + size
        return texts, at
    code, size = {2: ("q", 8), 4: ("f", 4), 5: ("d", 8)}[kind]
    return list(struct.unpack_from(f"<{count}{code}", data, at)), at + count * size


def nest(values, repetition, depth):
    """Rows of lists, by the levels at which values begin new ones."""
    if depth == 0:
        return values
    rows = []
    for value, level in zip(values, repetition):
        lists = rows
        for _ in range(level):  # the list that goes on
            lists = lists[-1]
        for _ in range(depth - level):
            lists.append([])
            lists = lists[-1]
        lists.append(value)
    return rows


def read_parquet(path):
    """Columns by name, row by row; and the metadata of the file."""
    with open(path, "rb") as file:
        data = file.read()
    check(data[:4] == data[-4:] == b"PAR1", f"{path}: no Parquet file")
    (size,) = struct.unpack_from("<I", data, len(data) - 8)
    footer = Compact(data, len(data) - 8 - size)
    meta = footer.value(STRUCT)
    check(footer.at == len(data) - 8, f"{path}: footer")
    schema, leaves = meta[2], []

    def walk(at, names):
        element = schema[at]
        name = names + [element[4].decode()]
        at += 1
        if 5 not in element:
            leaves.append((name[1:], element))
        for _ in range(element.get(5, 0)):
            at = walk(at, name)
        return at

    check(walk(0, []) == len(schema), f"{path}: schema")
    (group,) = meta[4]
    columns = {}
    for (names, element), chunk in zip(leaves, group[1], strict=True):
        about = chunk[3]
        check([each.decode() for each in about[3]] == names and about[1] == element[1] and about[4] == 0, f"{path}: {names}")
        depth = (len(names) - 1) // 2
        check(names[1:] == ["list", "element"] * depth, f"{path}: {names}")
        at, values, repetition = about[9], [], []
        while len(values) < about[5]:
            reader = Compact(data, at)
            page = reader.value(STRUCT)
            check(page[1] == 0 and page[2] == page[3] and page[5][2] == 0, f"{path}: page {page}")
            at, count = reader.at, page[5][1]
            end = at + page[3]
            if depth:
                own, at = levels(data, at, count, depth.bit_length())
                repetition += own
            defined, at = levels(data, at, count, (2 * depth + 1).bit_length())
            check(set(defined) == {2 * depth + 1}, f"{path}: {names} has values that are null")
            own, at = plain(data, at, element[1], count)
            values += own
            check(at == end, f"{path}: page of {names} ends at {at}, not {end}")
        check(at == about[9] + about[7], f"{path}: size of {names}")
        columns[names[0]] = nest(values, repetition, depth)
        check(len(columns[names[0]]) == meta[3] == group[3], f"{path}: rows of {names}")
    return columns, {each[1].decode(): each[2].decode() for each in meta.get(5, [])}
