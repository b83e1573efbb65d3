"""PNG files, without another package than NumPy."""
import struct
import zlib
from typing import TYPE_CHECKING, Any, Mapping

if TYPE_CHECKING:
    import numpy as np


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(color: "np.ndarray[Any, Any]", text: Mapping[str, str]) -> bytes:
    """Encodes (height, width, 3 or more) uint8 sRGB as 8-bit RGB. text: ASCII text chunks."""
    import numpy
    rgb = color[..., :3]
    height, width = rgb.shape[:2]
    rows = numpy.empty((height, width + 1, 3), numpy.uint8)
    rows[:, 1] = rgb[:, 0]
    numpy.subtract(rgb[:, 1:], rgb[:, :-1], out=rows[:, 2:])  # modulo 256: the filter Sub
    lines = numpy.empty((height, 3 * width + 1), numpy.uint8)
    lines[:, 0] = 1  # filter type Sub
    lines[:, 1:] = rows[:, 1:].reshape(height, 3 * width)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    texts = b"".join(_chunk(b"tEXt", f"{key}\0{value}".encode("latin-1")) for key, value in text.items())
    return b"".join((b"\x89PNG\r\n\x1a\n", _chunk(b"IHDR", header), _chunk(b"sRGB", b"\0"), texts,
                     _chunk(b"IDAT", zlib.compress(lines.tobytes(), 6)), _chunk(b"IEND", b"")))
