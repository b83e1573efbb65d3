"""Writer of MCAP files, written from the specification of the format: messages outside chunks, or in one chunk without
compression, and no summary.
"""
import struct
import zlib

MAGIC = b"\x89MCAP0\r\n"


def text(value):
    data = value.encode()
    return struct.pack("<I", len(data)) + data


def record(kind, content):
    return struct.pack("<BQ", kind, len(content)) + content


class McapWriter:
    def __init__(self, profile="ros2"):
        self.definitions, self.messages, self.times = record(1, text(profile) + text("test")), b"", []
        self.schemas, self.channels, self.sequences = {}, {}, {}

    def channel(self, topic, schema, encoding, schema_encoding=""):
        key = (topic, schema, encoding)
        if key not in self.channels:
            if schema not in self.schemas:
                self.schemas[schema] = len(self.schemas) + 1
                self.definitions += record(3, struct.pack("<H", self.schemas[schema]) + text(schema) + text(schema_encoding) + struct.pack("<I", 0))
            self.channels[key] = len(self.channels) + 1
            self.definitions += record(4, struct.pack("<HH", self.channels[key], self.schemas[schema]) + text(topic) + text(encoding)
                                       + struct.pack("<I", 0))
        return self.channels[key]

    def write(self, topic, schema, encoding, log_ns, data):
        channel = self.channel(topic, schema, encoding)
        self.sequences[channel] = self.sequences.get(channel, 0) + 1
        self.messages += record(5, struct.pack("<HIQQ", channel, self.sequences[channel], log_ns, log_ns) + data)
        self.times.append(log_ns)

    def save(self, path, chunked=False):
        body = self.messages
        if chunked:
            body = record(6, struct.pack("<QQQI", min(self.times), max(self.times), len(body), zlib.crc32(body)) + text("")
                          + struct.pack("<Q", len(body)) + body)
        with open(path, "wb") as file:
            file.write(MAGIC + self.definitions + body + record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + MAGIC)
        return path
