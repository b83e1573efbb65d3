"""Conversion of arguments to contiguous arrays of one type. NumPy is optional; contiguous NumPy arrays are not copied."""
import ctypes
import math
import sys
from enum import IntEnum
from typing import Any, List, Optional, Tuple, Type

from .errors import ArgumentError, ErrorCode


def _refuse(sentence: str) -> ArgumentError:
    return ArgumentError(ErrorCode.ARGUMENT, sentence)


def whole(value: Any, kind: Any, name: str) -> int:
    """Checks the range, because ctypes truncates silently."""
    try:
        number = value.__index__()
    except AttributeError:
        raise _refuse(f"{name} is {value!r}; a whole number is needed") from None
    if kind(number).value != number:
        raise _refuse(f"{name} is {number}, which does not fit into {8 * ctypes.sizeof(kind)} bits")
    return number


def enumerated(value: Any, kind: Type[IntEnum], name: str) -> int:
    """Checks a member of an enumeration, or its number."""
    try:
        return int(kind(value))
    except ValueError:
        members = ", ".join(f".{member}" for member in list(kind.__members__)[1:])
        raise _refuse(f"{name} is {value!r}; use fire3dv.{kind.__name__}.{next(iter(kind.__members__))}, or {members}") from None


def real(value: Any, name: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise _refuse(f"{name} is {value!r}; a number is needed") from None


def seconds(value: Any, name: str) -> float:
    """Checks a duration; infinity is one."""
    number = real(value, name)
    if not number >= 0:
        raise _refuse(f"{name} is {number:g}; 0 or more is needed")
    return number


def _flatten(numbers: Any, into: List[float]) -> None:
    for entry in numbers:
        if hasattr(entry, "__iter__") and not isinstance(entry, (str, bytes)):
            _flatten(entry, into)
        else:
            into.append(entry)


class Numbers:
    """Rows of numbers. `address` is valid for the lifetime of this object; None for no rows."""

    __slots__ = ("rows", "address", "_memory")

    def __init__(self, numbers: Any, row: Tuple[int, ...], name: str, kind: Any = ctypes.c_float,
                 dtype: str = "float32") -> None:
        """row: shape of one row, such as (3, 4); flat rows of equal length are accepted, too.

        For poses, (3, 4), matrices of the shape (4, 4) whose last row is 0 0 0 1 are accepted and copied.
        """
        if row == (3, 4):
            numbers = _upper_rows(numbers, name)
        per_row = 1
        for extent in row:
            per_row *= extent
        numpy = sys.modules.get("numpy")
        if numpy is not None and hasattr(numbers, "__array__"):
            count = self._take_array(numpy, numbers, row, per_row, name, dtype)
        else:
            count = self._take_any(numbers, row, per_row, name, kind)
        if count % per_row:
            raise _refuse(f"{name} has {count} numbers; {per_row} for each are needed")
        self.rows = count // per_row

    def _take_array(self, numpy: Any, numbers: Any, row: Tuple[int, ...], per_row: int, name: str, dtype: str) -> int:
        given = numpy.asarray(numbers)
        _check_shape(given.shape, row, per_row, name)
        kinds = "ui" if dtype == "uint32" else "fui"
        if given.size and given.dtype.kind not in kinds:
            raise _refuse(f"{name} is an array of {given.dtype}; {dtype} is needed")
        if dtype == "uint32" and given.size and (given.min() < 0 or given.max() > 0xffffffff):
            raise _refuse(f"{name} must lie between 0 and 4294967295")
        with numpy.errstate(over="ignore"):  # overflow becomes infinity, which the library refuses
            self._memory = numpy.ascontiguousarray(given, dtype=dtype)
        self.address: Optional[int] = self._memory.ctypes.data if given.size else None
        return int(given.size)

    def _take_any(self, numbers: Any, row: Tuple[int, ...], per_row: int, name: str, kind: Any) -> int:
        try:
            view = memoryview(numbers)
        except TypeError:
            view = None
        as_is = view is not None and view.format == kind._type_ and view.c_contiguous and not view.readonly
        if view is not None and as_is and view.nbytes:
            _check_shape(view.shape or (), row, per_row, name)
            count = view.nbytes // ctypes.sizeof(kind)
            self._memory = (kind * count).from_buffer(view.cast("B"))
        else:
            flat: List[float] = []
            try:
                if view is not None:
                    _check_shape(view.shape or (), row, per_row, name)
                _flatten(numbers if view is None else view.tolist(), flat)
                if kind is ctypes.c_uint32:
                    if any(entry != int(entry) or not 0 <= entry <= 0xffffffff for entry in flat):
                        raise ValueError("whole ones between 0 and 4294967295 are needed")
                    flat = [int(entry) for entry in flat]
                self._memory = (kind * len(flat))(*flat)
            except (TypeError, ValueError, OverflowError, NotImplementedError) as fault:
                raise _refuse(f"{name} must hold numbers: {fault}") from None
            count = len(flat)
        self.address = ctypes.addressof(self._memory) if count else None
        return count


def _shape_of(numbers: Any) -> Tuple[int, ...]:
    """Shape of an array, or of the first elements of nested sequences."""
    shape = getattr(numbers, "shape", None)
    if isinstance(shape, tuple):
        return shape
    if not isinstance(numbers, (list, tuple)):
        return ()
    return (len(numbers), *(_shape_of(numbers[0]) if numbers else ()))


def _upper_rows(numbers: Any, name: str) -> Any:
    """Drops the last rows of (4, 4) and (n, 4, 4) matrices, which must be 0 0 0 1. Returns other shapes unchanged."""
    shape = _shape_of(numbers)
    if len(shape) not in (2, 3) or shape[-2:] != (4, 4) or 0 in shape:
        return numbers
    numpy = sys.modules.get("numpy")
    if numpy is not None and hasattr(numbers, "__array__"):
        matrices = numpy.asarray(numbers).reshape(-1, 4, 4)
        if matrices.dtype.kind in "fui":
            for index in numpy.flatnonzero((matrices[:, 3] != (0, 0, 0, 1)).any(axis=1))[:1]:
                _refuse_last_row(matrices[index, 3].tolist(), index, name)
        return matrices[:, :3]
    nested = numbers.tolist() if isinstance(numbers, memoryview) else numbers
    upper = []
    for index, matrix in enumerate([nested] if len(shape) == 2 else nested):
        rows = [list(row) for row in matrix]
        if len(rows) != 4 or rows[3] != [0, 0, 0, 1]:
            _refuse_last_row(rows[3] if len(rows) > 3 else "missing", index, name)
        upper.append(rows[:3])
    return upper


def _refuse_last_row(row: Any, index: int, name: str) -> None:
    raise _refuse(f"{name}[{index}]: the last row of the 4x4 matrix is {row}; [0, 0, 0, 1] is needed: "
                  "is the matrix transposed?")


def rigid(numbers: Any, name: str) -> "Numbers":
    """One pose, (3, 4), (4, 4) or 12 numbers, without scale. None: no rows."""
    pose = Numbers(numbers if numbers is not None else [], (3, 4), name)
    if pose.rows > 1:
        raise _refuse(f"{name} has {pose.rows} poses; one is needed: 12 numbers, (3, 4) or (4, 4)")
    if pose.rows == 1:
        m = (ctypes.c_float * 12).from_address(pose.address or 0)
        for column in range(3):
            length = math.sqrt(sum(m[4 * r + column] ** 2 for r in range(3)))
            if abs(length - 1) > 0.01:  # NaN is refused by the library
                raise _refuse(f"{name} scales axis {'XYZ'[column]} by {length:.4g}; a camera has only a rotation "
                              "and a position")
    return pose


def _check_shape(shape: Tuple[int, ...], row: Tuple[int, ...], per_row: int, name: str) -> None:
    """Rejects wrong shapes of a matching size: three 4x4 matrices are not four 3x4 matrices."""
    if len(shape) <= 1 or shape[-len(row):] == row or shape[-1] == per_row:
        return
    wanted = ", ".join(str(extent) for extent in row)
    square = ", (n, 4, 4)" if row == (3, 4) else ""
    raise _refuse(f"{name} has the shape {tuple(shape)}; (n, {wanted}){square} or (n, {per_row}) is needed")
