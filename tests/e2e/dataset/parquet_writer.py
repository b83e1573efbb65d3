"""Writer of Parquet files by Python alone, as other programs write them: compressed pages of both versions, dictionaries, several
row groups and pages. For tests of readers."""
import struct
import zlib

I32, I64, BINARY, LIST, STRUCT, TRUE, FALSE = 5, 6, 8, 9, 12, 1, 2
KINDS = {"i": 1, "q": 2, "f": 4, "d": 5}  # struct's codes
PLAIN, RLE, RLE_DICTIONARY, BYTE_STREAM_SPLIT = 0, 3, 8, 9


def varint(value):
    out = b""
    while value >= 0x80:
        out += bytes([value & 0x7F | 0x80])
        value >>= 7
    return out + bytes([value])


def zigzag(value):
    return varint((value << 1) ^ (value >> 63))


class Long(int):
    """A 64-bit integer of Thrift."""


def compact(value):
    """Type and bytes in Thrift's compact protocol; structs are dictionaries by field."""
    if isinstance(value, bool):
        return (TRUE if value else FALSE), b""
    if isinstance(value, Long):
        return I64, zigzag(value)
    if isinstance(value, int):
        return I32, zigzag(value)
    if isinstance(value, str):
        return BINARY, varint(len(value.encode())) + value.encode()
    if isinstance(value, list):
        items = [compact(each) for each in value]
        kind = items[0][0]
        head = bytes([len(items) << 4 | kind]) if len(items) < 15 else bytes([0xF0 | kind]) + varint(len(items))
        return LIST, head + b"".join(data for _, data in items)
    out, last = b"", 0
    for field, each in value.items():
        kind, data = compact(each)
        out += (bytes([field - last << 4 | kind]) if field - last < 16 else bytes([kind]) + zigzag(field)) + data
        last = field
    return STRUCT, out + b"\0"


def snappy(data):
    """Literals, and copies where four bytes repeat at a distance of 4 or 8."""
    out, at, begin = varint(len(data)), 0, 0

    def literal(part):
        if not part:
            return b""
        if len(part) <= 60:
            return bytes([(len(part) - 1) << 2]) + part
        return bytes([61 << 2]) + struct.pack("<H", len(part) - 1) + part

    while at < len(data):
        for distance in (4, 8):
            length = 0
            while length < 60 and at >= distance and at + length < len(data) and data[at + length] == data[at + length - distance]:
                length += 1
            if length >= 4:
                break
        if length < 4:
            at += 1
            if at - begin == 60000:
                out += literal(data[begin:at])
                begin = at
            continue
        out += literal(data[begin:at])
        if length < 12 and distance < 2048:
            out += bytes([distance >> 8 << 5 | (length - 4) << 2 | 1, distance & 0xFF])
        else:
            out += bytes([(length - 1) << 2 | 2]) + struct.pack("<H", distance)
        at += length
        begin = at
    return out + literal(data[begin:])


def gzip(data):
    packer = zlib.compressobj(wbits=31)
    return packer.compress(data) + packer.flush()


def zstd(data):
    """A frame of blocks that are not compressed."""
    out = struct.pack("<IBQ", 0xFD2FB528, 0xE0, len(data))
    for at in range(0, max(len(data), 1), 100_000):
        block = data[at:at + 100_000]
        out += struct.pack("<I", len(block) << 3 | (at + 100_000 >= len(data)))[:3] + block
    return out


CODECS = {"none": (0, bytes), "snappy": (1, snappy), "gzip": (2, gzip), "zstd": (6, zstd), "lz4": (7, bytes)}


def hybrid(values, width):
    """Bit-packed groups for the first values, and runs for the rest."""
    packed = values[:len(values) // 16 * 8]
    out = b""
    if packed:
        bits = sum(value << width * i for i, value in enumerate(packed))
        out += varint(len(packed) // 8 << 1 | 1) + bits.to_bytes(len(packed) * width // 8, "little")
    for value in values[len(packed):]:
        out += varint(1 << 1) + value.to_bytes((width + 7) // 8, "little")
    return out


def write_parquet(path, columns, *, codec="none", pages=1, dictionary=False, split=False, group_rows=None, page_rows=None):
    """columns: name to (kind, rows); rows are numbers or lists of them."""
    number, pack = CODECS[codec]
    rows = len(next(iter(columns.values()))[1])
    data, groups = b"PAR1", []
    schema = [{4: "schema", 5: len(columns)}]
    for name, (kind, values) in columns.items():
        if isinstance(values[0], (list, tuple)):
            schema += [{3: 1, 4: name, 5: 1, 6: 3}, {3: 2, 4: "list", 5: 1}, {1: KINDS[kind], 3: 1, 4: "element"}]
        else:
            schema.append({1: KINDS[kind], 3: 1, 4: name})
    for first in range(0, rows, group_rows or rows):
        end = min(first + (group_rows or rows), rows)
        chunks = []
        for name, (kind, values) in columns.items():
            is_list = isinstance(values[0], (list, tuple))
            own = [list(row) if is_list else [row] for row in values[first:end]]
            begin, words, dictionary_at = len(data), sorted({each for row in own for each in row}), None
            if dictionary:
                dictionary_at = len(data)
                page = pack(struct.pack(f"<{len(words)}{kind}", *words))
                size = len(words) * struct.calcsize("<" + kind)
                data += compact({1: 2, 2: size, 3: len(page), 7: {1: len(words), 2: PLAIN}})[1] + page
            pages_at = len(data)
            for at in range(0, len(own), page_rows or len(own)):
                part = own[at:at + (page_rows or len(own))]
                flat = [each for row in part for each in row]
                repetition = hybrid([0 if i == 0 else 1 for row in part for i in range(len(row))], 1) if is_list else b""
                width = (3 if is_list else 1).bit_length()
                definition = hybrid([3 if is_list else 1] * len(flat), width)
                if dictionary:
                    bits = max(1, (len(words) - 1).bit_length())
                    encoding, body = RLE_DICTIONARY, bytes([bits]) + hybrid([words.index(each) for each in flat], bits)
                elif split:
                    plain = struct.pack(f"<{len(flat)}{kind}", *flat)
                    size = struct.calcsize("<" + kind)
                    encoding, body = BYTE_STREAM_SPLIT, b"".join(plain[k::size] for k in range(size))
                else:
                    encoding, body = PLAIN, struct.pack(f"<{len(flat)}{kind}", *flat)
                if pages == 1:
                    levels = b"".join(struct.pack("<I", len(each)) + each for each in ([repetition] if is_list else []) + [definition])
                    page = pack(levels + body)
                    header = {1: 0, 2: len(levels + body), 3: len(page), 5: {1: len(flat), 2: encoding, 3: RLE, 4: RLE}}
                else:
                    levels, packed = repetition + definition, pack(body)
                    page = levels + packed
                    header = {1: 3, 2: len(levels + body), 3: len(page),
                              8: {1: len(flat), 2: 0, 3: len(part), 4: encoding, 5: len(definition), 6: len(repetition), 7: True}}
                data += compact(header)[1] + page
            count, size = sum(map(len, own)), len(data) - begin
            about = {1: KINDS[kind], 2: [PLAIN, RLE], 3: [name, "list", "element"] if is_list else [name], 4: number, 5: Long(count), 6: Long(size),
                     7: Long(size), 9: Long(pages_at)}
            if dictionary_at is not None:
                about[11] = Long(dictionary_at)
            chunks.append({2: Long(begin), 3: about})
        groups.append({1: chunks, 2: Long(1), 3: Long(end - first)})
    footer = compact({1: 1, 2: schema, 3: Long(rows), 4: groups, 6: "a test"})[1]
    with open(path, "wb") as file:
        file.write(data + footer + struct.pack("<I", len(footer)) + b"PAR1")
