"""Inputs of a Stream: controls that people use in windows and browsers, and the events that they cause."""
from __future__ import annotations

import ctypes
from ctypes import byref, c_char_p
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

from .. import _library as c
from .._handle import StreamHandle
from .._library import check, encoded, library
from .._numbers import real
from ..errors import ArgumentError, ErrorCode, StateError

_BATCH = 64  # events of one call
_MAX_EVENTS = 1024  # of one events(): a renderer may send without end
_MAX_STEPS = 1_000_000
_RUN_PAUSE, _STEP, _RESET, _SPEED = 1, 2, 4, 8


class InputKind(IntEnum):
    """Kinds of inputs."""
    SLIDER = 0
    BUTTON = 1
    TOGGLE = 2
    CHOICE = 3
    TEXT = 4
    RUN = 5
    DRAG = 6


class Action(IntEnum):
    """What a person did with an input."""
    SET = 0
    PRESS = 1
    RUN = 2
    PAUSE = 3
    STEP = 4
    RESET = 5
    SPEED = 6
    BEGIN = 7
    MOVE = 8
    END = 9


@dataclass(frozen=True)
class Event:
    """What a person did; fire3dv_event in input.h."""
    input: str  #: name of the input
    kind: InputKind
    action: Action
    value: float  #: slider; toggle: 0 or 1; choice: index; number of steps; speed
    text: str  #: of a text
    viewer: int  #: who did it: 0 for the renderer's window, else the number of a browser's page
    source: int  #: random id of the renderer
    node: str  #: drag: the body, a name of describe()
    node_point: Tuple[float, float, float]  #: drag: grabbed point in the body's frame
    target: Tuple[float, float, float]  #: drag: where it is dragged to, in the stream's frame
    time_ns: int  #: on the renderer's monotonic clock; 0: the library ended a drag
    sim_time_ns: int  #: of the frame that the person saw
    lost: int  #: events dropped before this one


OnEvent = Optional[Callable[[Any], None]]


class Control:
    """A declared input. Its values change in Stream.events()."""

    def __init__(self, controls: Controls, name: str, raw: c.Input, on_change: OnEvent) -> None:
        self._controls, self._raw, self._on_change = controls, raw, on_change
        self.name = name
        controls._declare(self)

    def remove(self) -> None:
        """Removes the input. Its values cannot be set any more."""
        if self._is_declared():
            self._controls._remove(self.name)

    def _is_declared(self) -> bool:
        """Whether it was neither removed nor replaced by another of its name."""
        return self._controls._by_name.get(self.name) is self

    def _take(self, event: Event) -> Tuple[Any, ...]:
        """Takes the values of an event. Returns the arguments for the callback."""
        self._raw.value = event.value
        return (self._raw.value,)

    def _set(self, field: str, value: Any) -> None:
        if not self._is_declared():
            raise StateError(ErrorCode.STATE, f"the control {self.name!r} was removed, or declared again: use the newer one, "
                             "or declare it")
        before = getattr(self._raw, field)
        setattr(self._raw, field, value)
        try:
            self._controls._declare(self)
        except Exception:
            setattr(self._raw, field, before)
            raise


class Slider(Control):
    """A number in a range."""

    @property
    def value(self) -> float:
        """Current value; may be set."""
        return float(self._raw.value)

    @value.setter
    def value(self, value: float) -> None:
        self._set("value", real(value, "value"))


class Toggle(Control):
    """A yes or no."""

    @property
    def value(self) -> bool:
        """Current value; may be set."""
        return bool(self._raw.value)

    @value.setter
    def value(self, value: bool) -> None:
        self._set("value", float(bool(value)))

    def _take(self, event: Event) -> Tuple[Any, ...]:
        self._raw.value = event.value
        return (self.value,)


class Choice(Control):
    """One of several texts."""

    def __init__(self, controls: Controls, name: str, raw: c.Input, on_change: OnEvent, choices: List[str]) -> None:
        self.choices = choices
        super().__init__(controls, name, raw, on_change)

    @property
    def value(self) -> str:
        """The chosen text; may be set."""
        return self.choices[int(self._raw.value)]

    @value.setter
    def value(self, value: str) -> None:
        self._set("value", float(_index_of(value, self.choices)))

    def _take(self, event: Event) -> Tuple[Any, ...]:
        self._raw.value = event.value
        return (self.value,)


class Text(Control):
    """A line of text."""

    @property
    def value(self) -> str:
        """Current text; may be set."""
        return bytes(self._raw.text or b"").decode()

    @value.setter
    def value(self, value: str) -> None:
        self._set("text", encoded(value, "value"))

    def _take(self, event: Event) -> Tuple[Any, ...]:
        self._raw.text = event.text.encode()
        return (event.text,)


class Button(Control):
    """Calls on_press, and counts."""

    presses = 0  #: since it was declared

    def _take(self, event: Event) -> Tuple[Any, ...]:
        self.presses += 1
        return ()


class Run(Control):
    """A run bar: run and pause, step, reset, speed. The program obeys; nothing stops it else."""

    _steps = _resets = 0

    @property
    def running(self) -> bool:
        """Whether the simulation should run; may be set."""
        return bool(self._raw.value)

    @running.setter
    def running(self, running: bool) -> None:
        self._set("value", float(bool(running)))
        self._steps = 0

    @property
    def speed(self) -> float:
        """Simulated seconds per second; may be set."""
        return float(self._raw.speed)

    @speed.setter
    def speed(self, speed: float) -> None:
        self._set("speed", real(speed, "speed"))

    def take_steps(self) -> int:
        """Returns the steps requested since the last call, at most 1,000,000. Those before the last run, pause or reset
        do not count, nor those while it runs."""
        steps, self._steps = self._steps, 0
        return steps

    def take_reset(self) -> bool:
        """Returns whether a reset was requested since the last call."""
        resets, self._resets = self._resets, 0
        return resets > 0

    def _take(self, event: Event) -> Tuple[Any, ...]:
        if event.action in (Action.RUN, Action.PAUSE, Action.RESET):
            self._steps = 0
        if event.action in (Action.RUN, Action.PAUSE):
            self._raw.value = float(event.action == Action.RUN)
        elif event.action == Action.SPEED:
            self._raw.speed = event.value
        elif event.action == Action.STEP and not self.running:
            self._steps = min(self._steps + int(event.value), _MAX_STEPS)
        elif event.action == Action.RESET:
            self._resets += 1
        return (event,)


@dataclass(frozen=True)
class Pull:
    """A body that somebody drags."""
    node: str  #: a name of describe()
    node_point: Tuple[float, float, float]  #: grabbed point in the body's frame
    target: Tuple[float, float, float]  #: where it is dragged to, in the stream's frame


class Drag(Control):
    """Dragging of the stream's bodies. With a spring of stiffness k, the force on a body at node_point is
    k * (target - stream_from_body * node_point)."""

    def __init__(self, controls: Controls, name: str, raw: c.Input, on_change: OnEvent) -> None:
        self._held: Dict[Tuple[int, int], Pull] = {}  # by source and viewer
        super().__init__(controls, name, raw, on_change)

    @property
    def pulls(self) -> List[Pull]:
        """All drags at this moment: one of each viewer at most."""
        return list(self._held.values()) if self._is_declared() else []

    def _take(self, event: Event) -> Tuple[Any, ...]:
        if event.action == Action.END:
            self._held.pop((event.source, event.viewer), None)
        else:
            self._held[event.source, event.viewer] = Pull(event.node, event.node_point, event.target)
        return (event,)


def _index_of(value: str, choices: Sequence[str]) -> int:
    if value not in choices:
        raise ArgumentError(ErrorCode.ARGUMENT, f"value is {value!r}; the choices are {', '.join(map(repr, choices))}")
    return list(choices).index(value)


class Controls:
    """Declares the inputs of a stream: Stream.controls.

    What stands before the last "/" of a name is its folder in panels. Declaring a name again replaces the input.
    Callbacks run in Stream.events(), in the thread that calls it, when all controls have their new values. If one
    raises an exception the others are called all the same; then events() raises the first exception.
    """

    def __init__(self, stream: Inputs) -> None:
        self._stream = stream
        self._by_name: Dict[str, Control] = {}

    def slider(self, name: str, minimum: float, maximum: float, value: Optional[float] = None, step: float = 0.0,
               unit: str = "", on_change: Optional[Callable[[float], None]] = None) -> Slider:
        """Adds a slider. value: None: minimum. step: distance of its values; 0: any value."""
        raw = self._raw(InputKind.SLIDER, minimum=real(minimum, "minimum"), maximum=real(maximum, "maximum"),
                        step=real(step, "step"), unit=encoded(unit, "unit"),
                        value=real(minimum if value is None else value, "value"))
        return Slider(self, name, raw, on_change)

    def button(self, name: str, on_press: Optional[Callable[[], None]] = None) -> Button:
        """Adds a button."""
        return Button(self, name, self._raw(InputKind.BUTTON), on_press)  # type: ignore[arg-type]

    def toggle(self, name: str, value: bool = False, on_change: Optional[Callable[[bool], None]] = None) -> Toggle:
        """Adds a check box."""
        return Toggle(self, name, self._raw(InputKind.TOGGLE, value=float(bool(value))), on_change)

    def choice(self, name: str, choices: Sequence[str], value: Optional[str] = None,
               on_change: Optional[Callable[[str], None]] = None) -> Choice:
        """Adds a choice of 1 to 256 texts. value: None: the first."""
        texts = list(choices)
        raw_texts = (c_char_p * len(texts))(*[encoded(text, f"choices[{i}]") for i, text in enumerate(texts)])
        raw = self._raw(InputKind.CHOICE, choices=raw_texts, choice_count=len(texts),
                        value=float(0 if value is None else _index_of(value, texts)))
        return Choice(self, name, raw, on_change, texts)

    def text(self, name: str, value: str = "", on_change: Optional[Callable[[str], None]] = None) -> Text:
        """Adds a line of text, of at most 1023 bytes."""
        return Text(self, name, self._raw(InputKind.TEXT, text=encoded(value, "value")), on_change)

    def run(self, name: str = "run", running: bool = True, speeds: Optional[Tuple[float, float]] = None,
            speed: float = 1.0, can_pause: bool = True, can_step: bool = True, can_reset: bool = True,
            on_event: Optional[Callable[[Event], None]] = None) -> Run:
        """Adds a run bar. speeds: range of the speed; None: the speed is fixed."""
        flags = _RUN_PAUSE * can_pause | _STEP * can_step | _RESET * can_reset | _SPEED * (speeds is not None)
        low, high = speeds or (0.0, 0.0)
        raw = self._raw(InputKind.RUN, flags=flags, value=float(bool(running)), minimum=real(low, "speeds[0]"),
                        maximum=real(high, "speeds[1]"), speed=real(speed, "speed"))
        return Run(self, name, raw, on_event)

    def drag(self, name: str = "drag", stiffness: float = 0.0,
             on_event: Optional[Callable[[Event], None]] = None) -> Drag:
        """Lets people drag the stream's bodies. stiffness: N/m, for display; 0: unknown."""
        return Drag(self, name, self._raw(InputKind.DRAG, value=real(stiffness, "stiffness")), on_event)

    def __getitem__(self, name: str) -> Control:
        return self._by_name[name]

    def _raw(self, kind: InputKind, **fields: Any) -> c.Input:
        return c.Input(struct_size=ctypes.sizeof(c.Input), kind=int(kind), **fields)

    def _declare(self, control: Control) -> None:
        self._stream._call(library().fire3dv_declare_input, encoded(control.name, "name"), byref(control._raw))
        self._by_name[control.name] = control

    def _remove(self, name: str) -> None:
        self._stream._call(library().fire3dv_clear_input, encoded(name, "name"))
        self._by_name.pop(name, None)

    def _take(self, events: List[Event]) -> None:
        calls: List[Tuple[Control, Tuple[Any, ...]]] = []
        for event in events:
            control = self._by_name.get(event.input)
            if control is not None and control._raw.kind == event.kind:
                calls.append((control, control._take(event)))
        failure: Optional[Exception] = None
        for control, arguments in calls:
            if control._on_change is None or not control._is_declared():  # a callback may have removed it
                continue
            try:
                control._on_change(*arguments)
            except Exception as error:
                failure = failure or error
        if failure is not None:
            raise failure


class Inputs:
    """Functions of a Stream for inputs."""

    _call: Callable[..., None]
    _open_handle: Callable[[], StreamHandle]
    _node_names: Optional[List[str]]
    _controls: Optional[Controls]

    @property
    def controls(self) -> Controls:
        """Declares sliders, buttons, a run bar, ...; see Controls."""
        if self._controls is None:
            self._controls = Controls(self)
        return self._controls

    def events(self) -> List[Event]:
        """Returns what people have done since the last call; updates the controls, and calls their callbacks. At
        most 1024; the next call has the others. Never waits. Call it in each step."""
        raw = (c.Event * _BATCH)()
        found: List[Event] = []
        for _ in range(_MAX_EVENTS // _BATCH):
            raw[0].struct_size = ctypes.sizeof(c.Event)
            count = self._open_handle().call(library().fire3dv_poll_events, raw, _BATCH)
            if count < 0:
                check(count)
            found += [self._event_of(raw[i]) for i in range(count)]
            if count < _BATCH:
                break
        self.controls._take(found)
        return found

    def _event_of(self, raw: c.Event) -> Event:
        kind, names = InputKind(raw.kind), self._node_names or []
        node = names[raw.node] if kind == InputKind.DRAG and raw.node < len(names) else ""
        return Event(raw.input.decode("utf-8", "replace"), kind, Action(raw.action), raw.value,
                     raw.text.decode("utf-8", "replace"), raw.viewer, raw.source, node, tuple(raw.node_point),
                     tuple(raw.target), raw.time_ns, raw.sim_time_ns, raw.lost)
