"""Independent MCAP reader, written from the specification of the format: the oracle for the recorder's files.

It checks every checksum and every index, and decodes the numbers of pose frames from their FlatBuffers.
"""
import ctypes
import ctypes.util
import struct
import zlib

from image_reader import Failure, check

MAGIC = b"\x89MCAP0\r\n"


def unpack_zstd(packed, size):
    library = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
    library.ZSTD_decompress.restype = ctypes.c_size_t
    library.ZSTD_decompress.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t]
    buffer = ctypes.create_string_buffer(max(size, 1))
    got = library.ZSTD_decompress(buffer, size, packed, len(packed))
    check(got == size, f"a chunk unpacks to {got} bytes, not {size}")
    return buffer.raw[:size]


class Fields:
    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self, form):
        value, = struct.unpack_from("<" + form, self.data, self.at)
        self.at += struct.calcsize("<" + form)
        return value

    def bytes(self, length):
        check(self.at + length <= len(self.data), "a record ends too early")
        self.at += length
        return self.data[self.at - length:self.at]

    def text(self):
        return self.bytes(self.number("I")).decode()

    def texts(self):
        inner, result = Fields(self.bytes(self.number("I"))), {}
        while inner.at < len(inner.data):
            key = inner.text()
            result[key] = inner.text()
        return result

    def pairs(self, form):
        inner, result = Fields(self.bytes(self.number("I"))), []
        while inner.at < len(inner.data):
            result.append((inner.number(form), inner.number("Q")))
        return result


def records(data, at=0):
    """Returns (kind, content, offset) of each complete record."""
    while at + 9 <= len(data):
        kind, length = struct.unpack_from("<BQ", data, at)
        if kind == 0 or at + 9 + length > len(data):
            return
        yield kind, data[at + 9:at + 9 + length], at
        at += 9 + length


class McapFile:
    """whole: the file must be finished. Otherwise bytes behind the last complete record are ignored."""

    def __init__(self, path, whole=True):
        with open(path, "rb") as file:
            data = file.read()
        check(data[:8] == MAGIC, f"{path} is no MCAP file")
        self.schemas, self.channels, self.messages, self.attachments = {}, {}, [], []
        self.chunks, expected, kinds, self.end = [], None, [], None
        for kind, content, offset in records(data, 8):
            kinds.append(kind)
            fields = Fields(content)
            if self.end is None and expected and kind != 7:
                check(not expected, f"messages without an index before byte {offset}")
            if kind == 3:
                self._define(self.schemas, fields.number("H"), content)
            elif kind == 4:
                number, schema = fields.number("H"), fields.number("H")
                check(schema in self.schemas, f"channel {number} is of no schema")
                value = (fields.text(), fields.text(), fields.texts())
                self._define(self.channels, number, value)
            elif kind == 6:
                expected = self._chunk(fields, offset, len(content) + 9)
            elif kind == 7:
                channel = fields.number("H")
                check(fields.pairs("Q") == expected.pop(channel, None), f"the index at byte {offset} is wrong")
            elif kind == 9:
                self._attachment(fields, content)
            elif kind == 15:
                crc = fields.number("I")
                check(crc == zlib.crc32(data[:offset]), "the check sum over the data is wrong")
                self.end = offset
        check(kinds[0] == 1, "the first record is no header")
        if whole:
            self._summary(data)

    @staticmethod
    def _define(table, number, value):
        check(number != 0 and table.setdefault(number, value) == value, f"number {number} has two meanings")

    def _chunk(self, fields, offset, length):
        start, end, size, crc = (fields.number(form) for form in "QQQI")
        compression = fields.text()
        packed = fields.bytes(fields.number("Q"))
        check(compression in ("", "zstd"), f"packed with {compression}")
        unpacked = unpack_zstd(packed, size) if compression else packed
        check(len(unpacked) == size and zlib.crc32(unpacked) == crc, f"the chunk at byte {offset} is damaged")
        index, times = {}, []
        for kind, content, at in records(unpacked):
            check(kind == 5, f"a chunk holds a record of kind {kind}")
            message = Fields(content)
            channel, sequence, log_time, publish_time = (message.number(form) for form in "HIQQ")
            check(channel in self.channels, "a message comes before its channel")
            index.setdefault(channel, []).append((log_time, at))
            times.append(log_time)
            self.messages.append((channel, sequence, log_time, publish_time, content[22:]))
        check((start, end) == (min(times), max(times)), "a chunk's times are wrong")
        self.chunks.append((start, end, offset, length, size, len(packed)))
        return index

    def _attachment(self, fields, content):
        fields.number("Q"), fields.number("Q")
        name, media_type = fields.text(), fields.text()
        data = fields.bytes(fields.number("Q"))
        check(fields.number("I") == zlib.crc32(content[:-4]), "an attachment is damaged")
        self.attachments.append((name, media_type, data))

    def _summary(self, data):
        check(data[-8:] == MAGIC and self.end is not None, "the file has no end")
        kind, length, start, offsets, crc = struct.unpack("<BQQQI", data[-37:-8])
        check((kind, length) == (2, 20), "there is no footer")
        check(start == self.end + 13, "the summary does not follow the data")
        check(crc == zlib.crc32(data[start:-12]), "the check sum over the summary is wrong")
        groups, chunks = {}, []
        for kind, content, offset in records(data[:offsets], start):
            first, _ = groups.get(kind, (offset, 0))
            groups[kind] = (first, offset + 9 + len(content) - first)
            fields = Fields(content)
            if kind == 8:
                head = tuple(fields.number("Q") for _ in range(4))
                fields.pairs("H")
                fields.number("Q")
                fields.text()
                packed, size = fields.number("Q"), fields.number("Q")
                chunks.append((*head, size, packed))
            if kind == 11:
                total = fields.number("Q")
                check(total == len(self.messages), f"statistics say {total} messages, there are {len(self.messages)}")
        check(chunks == self.chunks, "the summary lists other chunks than there are")
        told = {}
        for kind, content, _ in records(data[:-37], offsets):
            fields = Fields(content)
            group = fields.number("B")
            told[group] = (fields.number("Q"), fields.number("Q"))
            check(kind == 14, "there is no such record behind the summary")
        check(told == groups, "the offsets of the summary are wrong")

    def of(self, role, stream=None):
        """Returns the messages of this role, in order, as (log time, bytes)."""
        wanted = {number for number, (_, _, meta) in self.channels.items()
                  if meta.get("fire3dv.role") == role and stream in (None, meta["fire3dv.stream"])}
        return [(log_time, data) for channel, _, log_time, _, data in self.messages if channel in wanted]


class Table:
    """One FlatBuffers table."""

    def __init__(self, data, at):
        self.data, self.at = data, at
        self.vtable = at - struct.unpack_from("<i", data, at)[0]

    def _field(self, number):
        size, = struct.unpack_from("<H", self.data, self.vtable)
        slot = 4 + 2 * number
        offset = struct.unpack_from("<H", self.data, self.vtable + slot)[0] if slot < size else 0
        return self.at + offset if offset else None

    def number(self, field, form, absent=0):
        at = self._field(field)
        return absent if at is None else struct.unpack_from("<" + form, self.data, at)[0]

    def follow(self, field):
        at = self._field(field)
        return None if at is None else at + struct.unpack_from("<I", self.data, at)[0]


def body_of(message):
    """Returns (body_type, its table)."""
    check(message[4:8] == b"F3DV", "a message is none of the protocol's")
    root = Table(message, struct.unpack_from("<I", message, 0)[0])
    return root.number(0, "B"), Table(message, root.follow(1))


def pose_frame(message):
    """Returns (epoch, sequence, sim time, x of each node) of a whole frame."""
    kind, frame = body_of(message)
    if kind != 2:
        raise Failure(f"a message of kind {kind} is no pose frame")
    at = frame.follow(8)
    count = struct.unpack_from("<I", message, at)[0] if at else 0
    xs = [struct.unpack_from("<f", message, at + 4 + 48 * i + 12)[0] for i in range(count)]
    return frame.number(0, "Q"), frame.number(1, "Q"), frame.number(2, "q"), xs
