"""Marker functions of a Stream: geometry that is shown besides bodies."""
from __future__ import annotations

import ctypes
import sys
from ctypes import byref, c_uint8, c_uint64
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

from . import _library as c
from ._library import encoded, library
from ._numbers import Numbers, enumerated, real, seconds
from ._types import Array, Pixels
from .errors import ArgumentError, ErrorCode
from .status import MarkerKind

_OVERLAID = 1


def _refuse(sentence: str) -> ArgumentError:
    return ArgumentError(ErrorCode.ARGUMENT, sentence)


class _Colors:
    """r g b a of 8 bits each. `address` is valid for the lifetime of this object; None for no colours."""

    def __init__(self, colors: Optional[Array], per_color: int = 1) -> None:
        """per_color: positions that take one colour."""
        numpy = sys.modules.get("numpy")
        self.rows = 0
        self.address: Optional[int] = None
        if colors is None:
            return
        if numpy is not None and hasattr(colors, "__array__"):
            self._memory = _rgba_array(numpy, numpy.asarray(colors), per_color)
            self.rows = len(self._memory)
            self.address = self._memory.ctypes.data if self.rows else None
            return
        quads = _rgba_rows(colors)
        if len(quads) > 1:  # one is for all
            quads = [quad for quad in quads for _ in range(per_color)]
        flat = [number for quad in quads for number in quad]
        self._memory = (c_uint8 * len(flat))(*flat)
        self.rows = len(quads)
        self.address = ctypes.addressof(self._memory) if self.rows else None


def _rgba_array(numpy: Any, given: Any, per_color: int) -> Any:
    if given.ndim not in (1, 2) or given.shape[-1] not in (3, 4):
        raise _refuse(f"colors has the shape {given.shape}; (3,), (4,), (n, 3) or (n, 4) is needed")
    rows = given.reshape(-1, given.shape[-1])
    if rows.dtype != numpy.uint8:
        if rows.dtype.kind not in "fui":
            raise _refuse(f"colors is an array of {rows.dtype}; numbers from 0 to 1, or uint8, are needed")
        if rows.size and not (rows.min() >= 0 and rows.max() <= 1):
            raise _refuse("colors must lie between 0 and 1; of an array of uint8, between 0 and 255")
        rows = numpy.rint(rows * 255.0).astype(numpy.uint8)
    if rows.shape[1] == 3:
        rows = numpy.concatenate([rows, numpy.full((len(rows), 1), 255, numpy.uint8)], axis=1)
    if per_color > 1 and len(rows) > 1:
        rows = rows.repeat(per_color, axis=0)
    return numpy.ascontiguousarray(rows)


def _rgba_rows(colors: Any) -> List[Tuple[int, ...]]:
    try:
        given = list(colors)
        nested = given if given and hasattr(given[0], "__iter__") else [given]
        result = []
        for color in nested:
            color = tuple(color)
            numbers = [float(number) for number in color[:5]]
            if len(numbers) not in (3, 4) or not all(0 <= number <= 1 for number in numbers):
                short = f"{repr(color[:5])[:80]} ({len(color)} numbers)"
                raise _refuse(f"colors has {short}; 3 or 4 numbers from 0 to 1 are needed, or an array of rows")
            result.append(tuple(round(255 * number) for number in (numbers + [1.0])[:4]))
        return result
    except (TypeError, ValueError) as fault:
        raise _refuse(f"colors must hold numbers: {fault}") from None


class _Pixels:
    """Rows of 8-bit pixels. `address` is valid for the lifetime of this object; None for no image."""

    def __init__(self, pixels: Any) -> None:
        self.address: Optional[int] = None
        self.width = self.height = self.channels = 0
        if pixels is None:
            return
        numpy = sys.modules.get("numpy")
        if numpy is not None and hasattr(pixels, "__array__"):
            pixels = numpy.asarray(pixels)
        try:
            view = memoryview(pixels)
        except (TypeError, ValueError) as fault:
            raise _refuse(f"pixels must be an array of uint8: {fault}") from None
        if view.format != "B" or view.ndim not in (2, 3) or (view.ndim == 3 and view.shape[2] not in (1, 3, 4)):
            raise _refuse(f"pixels has the shape {tuple(view.shape)} and the format {view.format!r}; uint8 of (height, "
                          "width), or with 1, 3 or 4 channels, is needed")
        self.height, self.width = view.shape[:2]
        self.channels = view.shape[2] if view.ndim == 3 else 1
        most = 1024
        if not (1 <= self.width <= most and 1 <= self.height <= most):
            raise _refuse(f"pixels has {self.width} x {self.height} pixels; 1 to {most} a side are allowed: scale it "
                          "down")
        memory = c_uint8 * view.nbytes
        if view.c_contiguous and not view.readonly:
            self._memory = memory.from_buffer(view)
        else:
            self._memory = memory.from_buffer_copy(view.tobytes())
        self.address = ctypes.addressof(self._memory)


def _width(pixels: Optional[float], lengths: Optional[float], default_px: float, name: str) -> Tuple[float, int]:
    if pixels is not None and lengths is not None:
        raise _refuse(f"{name}_px and {name}_m are both given; one of them is needed")
    if lengths is not None:
        return real(lengths, f"{name}_m"), 1
    return real(default_px if pixels is None else pixels, f"{name}_px"), 0


def _pairs(starts: Array, vectors: Array) -> Any:
    """Tail and tip of each arrow, one after the other."""
    numpy = sys.modules.get("numpy")
    if numpy is not None and hasattr(starts, "__array__"):
        tails = numpy.asarray(starts, dtype=numpy.float32).reshape(-1, 3)
        along = numpy.asarray(vectors, dtype=numpy.float32).reshape(-1, 3)
        if len(tails) != len(along):
            raise _refuse(f"{len(along)} vectors for {len(tails)} starts")
        pairs = numpy.empty((len(tails), 2, 3), numpy.float32)
        pairs[:, 0] = tails
        numpy.add(tails, along, out=pairs[:, 1])
        return pairs
    tail_rows, along_rows = Numbers(starts, (3,), "starts"), Numbers(vectors, (3,), "vectors")
    if tail_rows.rows != along_rows.rows:
        raise _refuse(f"{along_rows.rows} vectors for {tail_rows.rows} starts")
    count = 3 * tail_rows.rows
    if count == 0:
        return []
    tail = (ctypes.c_float * count).from_address(tail_rows.address or 0)
    vector = (ctypes.c_float * count).from_address(along_rows.address or 0)
    return [[tail[i:i + 3], [t + v for t, v in zip(tail[i:i + 3], vector[i:i + 3])]] for i in range(0, count, 3)]


class Markers:
    """Marker functions of a Stream. A marker is a scene edit whose key is its name, "namespace/name" by convention.

    Arguments of all functions:
    colors: one for all or one per position (arrows: per arrow), sRGB with or without alpha: uint8 arrays, or numbers
        from 0 to 1. None: white. parent: scene node, in whose frame the marker is; None: the stream's frame.
    parent_from_marker: (3, 4) or (4, 4). lifetime_s: simulator time from the frame published last; 0: until it is
        replaced or cleared. overlaid: not hidden by surfaces.
    Contiguous float32 and (n, 4) uint8 arrays are passed to the library without a copy, except by arrows.
    """

    _call: Callable[..., None]

    def set_marker(self, name: str, kind: Union[MarkerKind, int], positions: Array, *, rotations: Optional[Array] = None,
                   sizes: Union[Array, float, None] = None, colors: Optional[Array] = None,
                   width_px: Optional[float] = None, width_m: Optional[float] = None, parent: Optional[str] = None,
                   parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False,
                   texts: Optional[Sequence[str]] = None, pixels: Optional[Pixels] = None, _positions_per_color: int = 1) -> None:
        """Sets or replaces a marker of any kind; the other functions call this one."""
        places = Numbers(positions, (3,), "positions")
        turns = Numbers(rotations if rotations is not None else [], (4,), "rotations")
        if isinstance(sizes, (int, float)):
            sizes = [sizes] * 3
        extents = Numbers(sizes if sizes is not None else [], (3,), "sizes")
        matrix = Numbers(parent_from_marker if parent_from_marker is not None else [], (3, 4), "parent_from_marker")
        if matrix.rows > 1:
            raise _refuse("parent_from_marker must hold 12 numbers")
        rgba = _Colors(colors, _positions_per_color)
        width, unit = _width(width_px, width_m, 1.0, "width")
        lifetime_ns = seconds(lifetime_s, "lifetime_s") * 1e9
        if lifetime_ns >= 2**63:
            raise _refuse(f"lifetime_s is {lifetime_s}; at most 292 years are allowed, and 0 has no end")
        strings = _strings(texts)
        image = pixels if isinstance(pixels, _Pixels) else _Pixels(pixels)
        marker = c.Marker(ctypes.sizeof(c.Marker), enumerated(kind, MarkerKind, "kind"), unit, width, _OVERLAID if overlaid else 0,
                          c_uint64(round(lifetime_ns)), encoded(parent, "parent"), matrix.address, places.address,
                          places.rows, turns.address, turns.rows, extents.address, extents.rows, rgba.address,
                          rgba.rows, ctypes.addressof(strings) if strings else None, len(strings), image.address,
                          image.width, image.height, image.channels)
        self._call(library().fire3dv_set_marker, encoded(name, "name"), byref(marker))

    def clear_marker(self, name: str) -> None:
        """Removes the marker. A name without a marker is no error."""
        self._call(library().fire3dv_clear_marker, encoded(name, "name"))

    def points(self, name: str, positions: Array, colors: Optional[Array] = None, size_px: Optional[float] = None,
               size_m: Optional[float] = None, *, parent: Optional[str] = None,
               parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Round points. positions: (n, 3). size_px or size_m: diameter; 5 pixels where both are left out."""
        width, unit = _width(size_px, size_m, 5.0, "size")
        self.set_marker(name, MarkerKind.POINTS, positions, colors=colors, **_named(width, unit), parent=parent,
                        parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def lines(self, name: str, positions: Array, colors: Optional[Array] = None, width_px: Optional[float] = None,
              width_m: Optional[float] = None, *, parent: Optional[str] = None,
              parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Segments. positions: (2 n, 3) or (n, 2, 3). The width is 2 pixels where it is left out."""
        width, unit = _width(width_px, width_m, 2.0, "width")
        self.set_marker(name, MarkerKind.LINES, positions, colors=colors, **_named(width, unit), parent=parent,
                        parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def line_strip(self, name: str, positions: Array, colors: Optional[Array] = None, width_px: Optional[float] = None,
                   width_m: Optional[float] = None, *, parent: Optional[str] = None,
                   parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """A line through all positions, (n, 3). The width is 2 pixels where it is left out."""
        width, unit = _width(width_px, width_m, 2.0, "width")
        self.set_marker(name, MarkerKind.LINE_STRIP, positions, colors=colors, **_named(width, unit), parent=parent,
                        parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def arrows(self, name: str, starts: Array, vectors: Array, colors: Optional[Array] = None,
               width_px: Optional[float] = None, width_m: Optional[float] = None, *, parent: Optional[str] = None,
               parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Arrows from starts to starts + vectors, both (n, 3). The shaft's diameter is 4 pixels where it is left out."""
        width, unit = _width(width_px, width_m, 4.0, "width")
        self.set_marker(name, MarkerKind.ARROWS, _pairs(starts, vectors), colors=colors, **_named(width, unit),
                        _positions_per_color=2, parent=parent, parent_from_marker=parent_from_marker,
                        lifetime_s=lifetime_s, overlaid=overlaid)

    def axes(self, name: str, positions: Array, rotations: Optional[Array] = None, sizes: Union[Array, float] = 0.1,
             width_px: Optional[float] = None, width_m: Optional[float] = None, *, parent: Optional[str] = None,
             parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Frames: x red, y green, z blue. rotations: (n, 4) x y z w. sizes: lengths of the axes."""
        width, unit = _width(width_px, width_m, 3.0, "width")
        self.set_marker(name, MarkerKind.AXES, positions, rotations=rotations, sizes=sizes, **_named(width, unit),
                        parent=parent, parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def boxes(self, name: str, positions: Array, sizes: Union[Array, float] = 0.1, rotations: Optional[Array] = None,
              colors: Optional[Array] = None, *, parent: Optional[str] = None,
              parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Boxes. positions: centres. sizes: full extents, one number, (3,) or (n, 3)."""
        self.set_marker(name, MarkerKind.BOXES, positions, rotations=rotations, sizes=sizes, colors=colors,
                        parent=parent, parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def spheres(self, name: str, positions: Array, sizes: Union[Array, float] = 0.1, rotations: Optional[Array] = None,
                colors: Optional[Array] = None, *, parent: Optional[str] = None,
                parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Spheres and ellipsoids. sizes: diameters, one number, (3,) or (n, 3)."""
        self.set_marker(name, MarkerKind.SPHERES, positions, rotations=rotations, sizes=sizes, colors=colors,
                        parent=parent, parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def cylinders(self, name: str, positions: Array, sizes: Array, rotations: Optional[Array] = None,
                  colors: Optional[Array] = None, *, parent: Optional[str] = None,
                  parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Cylinders along z. sizes: (3,) or (n, 3): diameters x and y, length."""
        self.set_marker(name, MarkerKind.CYLINDERS, positions, rotations=rotations, sizes=sizes, colors=colors,
                        parent=parent, parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def capsules(self, name: str, positions: Array, sizes: Array, rotations: Optional[Array] = None,
                 colors: Optional[Array] = None, *, parent: Optional[str] = None,
                 parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Capsules along z. sizes: (3,) or (n, 3): diameters x and y, length without the half spheres."""
        self.set_marker(name, MarkerKind.CAPSULES, positions, rotations=rotations, sizes=sizes, colors=colors,
                        parent=parent, parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def triangles(self, name: str, positions: Array, colors: Optional[Array] = None, *, parent: Optional[str] = None,
                  parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Triangles, seen from both sides. positions: (3 n, 3) or (n, 3, 3)."""
        self.set_marker(name, MarkerKind.TRIANGLES, positions, colors=colors, parent=parent,
                        parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def text(self, name: str, text: Union[str, Sequence[str]], positions: Array, colors: Optional[Array] = None,
             size_px: Optional[float] = None, size_m: Optional[float] = None, *, parent: Optional[str] = None,
             parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """Texts that face the viewer, centred on their positions. text: one, or one per position; lines end with "\\n".

        size_px or size_m: font size, of which capitals are 0.73 high; 16 pixels where both are left out.
        """
        width, unit = _width(size_px, size_m, 16.0, "size")
        self.set_marker(name, MarkerKind.TEXTS, positions, colors=colors,
                        texts=[text] if isinstance(text, str) else text, **_named(width, unit), parent=parent,
                        parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)

    def image(self, name: str, pixels: Pixels, size_m: Union[float, Sequence[float], None] = None,
              position: Array = (0.0, 0.0, 0.0), rotation: Optional[Array] = None, *, parent: Optional[str] = None,
              parent_from_marker: Optional[Array] = None, lifetime_s: float = 0.0, overlaid: bool = False) -> None:
        """An image on a rectangle, seen from both sides, in its own colours. pixels: uint8 of (height, width), or (height,
        width, 1, 3 or 4), sRGB; at most 1024 a side.

        size_m: width and height, or the width alone, which keeps the pixels square; None: 1. position: of the centre.
        rotation: x y z w; without one the image faces +z, its top is at +y.
        """
        image = _Pixels(pixels)
        if image.address is None:
            raise _refuse("pixels is None; an array of uint8 is needed")
        if size_m is None:
            size_m = 1.0
        if not hasattr(size_m, "__iter__"):
            width = real(size_m, "size_m")
            size = (width, width * image.height / image.width)
        else:
            size = tuple(real(length, "size_m") for length in size_m)  # type: ignore
            if len(size) != 2:
                raise _refuse(f"size_m has {len(size)} numbers; width and height, or the width alone, are needed")
        self.set_marker(name, MarkerKind.IMAGES, [tuple(position)], sizes=[(*size, 0.0)],
                        rotations=None if rotation is None else [tuple(rotation)],
                        pixels=image,  # type: ignore[arg-type]
                        parent=parent, parent_from_marker=parent_from_marker, lifetime_s=lifetime_s, overlaid=overlaid)


def _strings(texts: Optional[Sequence[str]]) -> Any:
    """An array of C strings, which must outlive the call that takes its address."""
    rows = [encoded(text, f"texts[{i}]") for i, text in enumerate(texts if texts is not None else [])]
    if None in rows:
        raise _refuse(f"texts[{rows.index(None)}] is None; a str is needed")
    return (ctypes.c_char_p * len(rows))(*rows)


def _named(width: float, unit: int) -> Dict[str, Any]:
    return {"width_m": width} if unit else {"width_px": width}
