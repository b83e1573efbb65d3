"""PNG files, without another package than NumPy."""
import struct
import zlib
from typing import TYPE_CHECKING, Mapping

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _file(header: bytes, chunks: bytes, texts: Mapping[str, str], lines: bytes) -> bytes:
    """header: of IHDR. chunks: between it and the texts. lines: filtered rows."""
    text = b"".join(_chunk(b"tEXt", f"{key}\0{value}".encode("latin-1")) for key, value in texts.items())
    return b"".join((b"\x89PNG\r\n\x1a\n", _chunk(b"IHDR", header), chunks, text,
                     _chunk(b"IDAT", zlib.compress(lines, 6)), _chunk(b"IEND", b"")))


def _filtered(pixels: "npt.NDArray[np.uint8]") -> bytes:
    """(height, width, bytes of a pixel) to rows with the filter Sub: differences to the pixel on the left."""
    import numpy
    height, width, size = pixels.shape
    lines = numpy.empty((height, size * width + 1), numpy.uint8)
    lines[:, 0] = 1  # filter type Sub
    lines[:, 1:1 + size] = pixels[:, 0]
    numpy.subtract(pixels[:, 1:].reshape(height, -1), pixels[:, :-1].reshape(height, -1),
                   out=lines[:, 1 + size:])  # modulo 256
    return lines.tobytes()


def png(color: "npt.NDArray[np.uint8]", texts: Mapping[str, str]) -> bytes:
    """Encodes (height, width, 3 or more) uint8 sRGB as 8-bit RGB. texts: ASCII text chunks."""
    height, width = color.shape[:2]
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return _file(header, _chunk(b"sRGB", b"\0"), texts, _filtered(color[..., :3]))


def gray_png(values: "npt.NDArray[np.uint16]", texts: Mapping[str, str]) -> bytes:
    """Encodes (height, width) uint16 as 16-bit grey. texts: ASCII text chunks."""
    import numpy
    height, width = values.shape
    header = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    big_endian = numpy.ascontiguousarray(values, ">u2").view(numpy.uint8).reshape(height, width, 2)
    return _file(header, b"", texts, _filtered(big_endian))
