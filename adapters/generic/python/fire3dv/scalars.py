"""Scalar functions of a Stream: named numbers with units, published besides poses."""
from __future__ import annotations

import ctypes
import math
from ctypes import byref, c_char_p, c_double, c_int64
from typing import Callable, Dict, Iterable, Mapping, Optional

from . import _library as c
from ._handle import StreamHandle
from ._library import encoded, library
from ._numbers import Numbers, real, whole
from ._types import Array
from .errors import ArgumentError, ErrorCode


def _refuse(sentence: str) -> ArgumentError:
    return ArgumentError(ErrorCode.ARGUMENT, sentence)


class Scalars:
    """Scalar functions of a Stream. Scalars are declared in groups; a stream has at most 4096 of them in all groups.

    NaN or infinity means: no value at this time. Values are shown in their unit, never converted. As long as a link and
    its reader keep up, renderers and recordings receive every array of values; pose frames do not wait for them. No
    function blocks.
    """

    _call: Callable[..., None]
    _open_handle: Callable[[], StreamHandle]
    _scalar_units: Dict[str, Dict[str, str]]

    def scalars(self, group: str, sim_time_ns: int, values: Mapping[str, float],
                units: Optional[Mapping[str, str]] = None) -> None:
        """Sets scalars by name at one simulation time, and declares those that are not declared yet.

        units: by name, for scalars that this call declares. Declared scalars that values lacks have no value at this
        time. For many scalars at high rates, declare_scalars and set_scalars are faster.
        """
        with self._open_handle().lock:  # two threads may declare scalars of one group
            declared = self._scalar_units.get(group, {})
            new = [name for name in values if name not in declared]
            if new:
                given = units or {}
                wanted = {**declared, **{name: given.get(name, "") for name in new}}
                self.declare_scalars(group, list(wanted), list(wanted.values()))
                declared = self._scalar_units[group]
            elif not values:
                raise _refuse("values is empty; at least one scalar is needed")
            numbers = [real(values[name], f"values[{name!r}]") if name in values else math.nan for name in declared]
            self.set_scalars(group, sim_time_ns, numbers)

    def declare_scalars(self, group: str, names: Iterable[str], units: Optional[Iterable[str]] = None) -> None:
        """Declares a group of scalars, or declares it again: values set before belong to the old declaration.

        names: all different. units: one for each name, such as "rad" or "N m", "" for none; None: no scalar has a unit.
        Raises ArgumentError, or BudgetError for more than 4096 scalars; then the old declaration stays in force.
        """
        if isinstance(names, str) or isinstance(units, str):
            raise _refuse("names and units must be lists of texts, not one str")
        name_list = list(names)
        unit_list = [""] * len(name_list) if units is None else list(units)
        if len(unit_list) != len(name_list):
            raise _refuse(f"{len(unit_list)} units for {len(name_list)} names")
        raw_names = [encoded(name, f"names[{i}]") for i, name in enumerate(name_list)]
        raw_units = [encoded(unit, f"units[{i}]") for i, unit in enumerate(unit_list)]
        count = len(raw_names)
        declaration = c.Scalars(ctypes.sizeof(c.Scalars), (c_char_p * count)(*raw_names),
                                (c_char_p * count)(*raw_units), count)
        with self._open_handle().lock:
            self._call(library().fire3dv_declare_scalars, encoded(group, "group"), byref(declaration))
            self._scalar_units[group] = dict(zip(name_list, unit_list))

    def set_scalars(self, group: str, sim_time_ns: int, values: Array) -> None:
        """Sets all values of a declared group at one simulation time, in the order of its names.

        values: (n,) float64 without a copy to Python objects, or any sequence of numbers. A time before the last one
        restarts the group's history. Raises StateError if the group is not declared.
        """
        numbers = Numbers(values, (1,), "values", c_double, "float64")
        self._call(library().fire3dv_set_scalars, encoded(group, "group"),
                   whole(sim_time_ns, c_int64, "sim_time_ns"), numbers.address, numbers.rows)

    def clear_scalars(self, group: str) -> None:
        """Removes the group. A name without a group is no error."""
        self._call(library().fire3dv_clear_scalars, encoded(group, "group"))
        self._scalar_units.pop(group, None)
