"""Writers of transforms and joint states as other programs encode them: CDR of either byte order, Protocol Buffers, JSON.

A transform is (stamp in ns, parent, child, translation, quaternion x y z w).
"""
import json
import struct


class CdrWriter:
    def __init__(self, order="<"):
        self.order, self.data = order, b""

    def number(self, kind, value):
        size = struct.calcsize(kind)
        self.data += b"\0" * (-len(self.data) % size) + struct.pack(self.order + kind, value)

    def string(self, value):
        data = value.encode() + b"\0"
        self.number("I", len(data))
        self.data += data

    def stamp(self, stamp_ns):
        self.number("i", stamp_ns // 10**9)
        self.number("I", stamp_ns % 10**9)

    def message(self):
        return (b"\0\1\0\0" if self.order == "<" else b"\0\0\0\0") + self.data


def cdr_transforms(transforms, order="<"):
    writer = CdrWriter(order)
    writer.number("I", len(transforms))
    for stamp_ns, parent, child, translation, rotation in transforms:
        writer.stamp(stamp_ns)
        writer.string(parent)
        writer.string(child)
        for value in (*translation, *rotation):
            writer.number("d", value)
    return writer.message()


def cdr_joint_state(stamp_ns, positions, order="<"):
    """positions: by name."""
    writer = CdrWriter(order)
    writer.stamp(stamp_ns)
    writer.string("")
    writer.number("I", len(positions))
    for name in positions:
        writer.string(name)
    writer.number("I", len(positions))
    for value in positions.values():
        writer.number("d", value)
    for _ in ("velocity", "effort"):
        writer.number("I", 0)
    return writer.message()


def varint(value):
    data = b""
    while value >= 0x80:
        data += bytes([value & 0x7F | 0x80])
        value >>= 7
    return data + bytes([value])


def field(number, data):
    return varint(number << 3 | 2) + varint(len(data)) + data


def doubles(values):
    return b"".join(varint(i << 3 | 1) + struct.pack("<d", value) for i, value in enumerate(values, 1) if value != 0)


def protobuf_transform(transform):
    stamp_ns, parent, child, translation, rotation = transform
    time = varint(1 << 3) + varint(stamp_ns // 10**9) + varint(2 << 3) + varint(stamp_ns % 10**9)
    unknown = varint(99 << 3) + varint(300) + varint(98 << 3 | 5) + b"abcd"  # of a later version
    return field(1, time) + field(2, parent.encode()) + unknown + field(3, child.encode()) + field(4, doubles(translation)) + field(5, doubles(rotation))


def protobuf_transforms(transforms):
    return b"".join(field(1, protobuf_transform(each)) for each in transforms)


def json_value(transform):
    stamp_ns, parent, child, translation, rotation = transform
    return {"timestamp": {"sec": stamp_ns // 10**9, "nsec": stamp_ns % 10**9}, "parent_frame_id": parent, "child_frame_id": child,
            "translation": dict(zip("xyz", translation)), "rotation": dict(zip("xyzw", rotation))}


def json_transforms(transforms):
    return json.dumps({"transforms": [json_value(each) for each in transforms]}).encode()
