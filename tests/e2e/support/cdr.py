"""Reader of ROS 2 messages by the rules of CDR (little endian, XCDR1), written from the message definitions: each
primitive is aligned to its size, counted from the end of the four bytes of the header."""
import struct

from image_reader import check


class Cdr:
    def __init__(self, data):
        check(data[:2] == b"\x00\x01", f"not CDR, little endian: {data[:4].hex()}")
        self.data, self.at = data[4:], 0

    def number(self, kind):
        size = struct.calcsize(kind)
        self.at += -self.at % size
        value = struct.unpack_from("<" + kind, self.data, self.at)[0]
        self.at += size
        return value

    def numbers(self, kind, count):
        return [self.number(kind) for _ in range(count)]

    def string(self):
        length = self.number("I")
        text = self.data[self.at:self.at + length]
        self.at += length
        check(text[-1:] == b"\0" and b"\0" not in text[:-1], f"a string of {length} bytes: {text!r}")
        return text[:-1].decode()

    def octets(self):
        length = self.number("I")
        octets = self.data[self.at:self.at + length]
        check(len(octets) == length, "a sequence is cut")
        self.at += length
        return octets

    def header(self):
        seconds, nanoseconds = self.number("i"), self.number("I")
        return {"stamp_ns": seconds * 10**9 + nanoseconds, "frame_id": self.string()}

    def end(self):
        """Only padding to a multiple of four may follow."""
        check(len(self.data) - self.at < 4, f"{len(self.data) - self.at} bytes follow the message")


def image(data):
    cdr = Cdr(data)
    message = {**cdr.header(), "height": cdr.number("I"), "width": cdr.number("I"), "encoding": cdr.string(),
               "is_bigendian": cdr.number("B"), "step": cdr.number("I"), "data": cdr.octets()}
    cdr.end()
    return message


def compressed_image(data):
    cdr = Cdr(data)
    message = {**cdr.header(), "format": cdr.string(), "data": cdr.octets()}
    cdr.end()
    return message


def camera_info(data):
    cdr = Cdr(data)
    message = {**cdr.header(), "height": cdr.number("I"), "width": cdr.number("I"), "distortion_model": cdr.string(),
               "d": cdr.numbers("d", cdr.number("I")), "k": cdr.numbers("d", 9), "r": cdr.numbers("d", 9),
               "p": cdr.numbers("d", 12), "binning": cdr.numbers("I", 2), "roi": cdr.numbers("I", 4),
               "do_rectify": cdr.number("B")}
    cdr.end()
    return message


def tf_message(data):
    cdr = Cdr(data)
    transforms = [{**cdr.header(), "child_frame_id": cdr.string(), "transform": cdr.numbers("d", 7)}
                  for _ in range(cdr.number("I"))]
    cdr.end()
    return transforms
