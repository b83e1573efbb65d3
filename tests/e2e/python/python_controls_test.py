"""Test of the controls of a stream, whose events come from this test in place of a renderer: callbacks that fail, steps of
a run bar, controls that were removed, and a renderer that sends without end."""
import ctypes
import itertools

import fire3dv
from fire3dv import _library
from fire3dv.controls import Action, InputKind


class Renderer:
    """Gives the events of a list, or of an endless source, to a stream that polls."""

    def __init__(self, stream):
        self.events, self.call = iter(()), stream._handle.call
        stream._handle.call = self.answer

    def answer(self, function, *arguments):
        if function is not _library.library().fire3dv_poll_events:
            return self.call(function, *arguments)
        raw, capacity = arguments
        count = 0
        for count, fields in enumerate(itertools.islice(self.events, capacity), 1):
            raw[count - 1] = _library.Event(struct_size=ctypes.sizeof(_library.Event), **fields)
        return count

    def act(self, *events):
        self.events = iter(events)


def event(name, kind, action, value=0.0, **fields):
    return dict(input=name.encode(), kind=int(kind), action=int(action), value=value, **fields)


def failing(*_):
    raise ValueError("of the program")


def raises(kind, call, text):
    try:
        call()
    except kind as error:
        assert text in str(error), error
        return
    raise AssertionError(f"nothing was raised, expected: {text}")


with fire3dv.Stream("udp://127.0.0.1:9") as stream:
    renderer = Renderer(stream)
    stream.describe(["arm"])
    seen = []

    # A callback that raises loses no event of others.
    fails = stream.controls.button("fails", on_press=failing)
    gain = stream.controls.slider("gain", 0, 10, on_change=lambda value: seen.append((value, drag.pulls)))
    drag = stream.controls.drag()
    held = dict(source=1, viewer=0, node=0)
    renderer.act(event("drag", InputKind.DRAG, Action.BEGIN, **held))
    stream.events()
    assert [pull.node for pull in drag.pulls] == ["arm"]
    renderer.act(event("fails", InputKind.BUTTON, Action.PRESS), event("gain", InputKind.SLIDER, Action.SET, 4.0),
                 event("drag", InputKind.DRAG, Action.END, **held))
    raises(ValueError, stream.events, "of the program")
    assert fails.presses == 1 and gain.value == 4 and drag.pulls == [] and seen == [(4, [])], seen
    assert stream.events() == []

    # Steps count while it is paused, after the last run, pause or reset.
    run = stream.controls.run(running=True)

    def steps_after(*actions):
        renderer.act(*(event("run", InputKind.RUN, action, 3.0) for action in actions))
        stream.events()
        return run.take_steps()

    assert steps_after(Action.STEP) == 0, "it runs"
    assert steps_after(Action.PAUSE, Action.STEP, Action.STEP) == 6
    assert steps_after(Action.STEP, Action.RESET, Action.STEP) == 3 and run.take_reset() and not run.take_reset()
    assert steps_after(Action.STEP, Action.RUN, Action.PAUSE) == 0
    renderer.act(*(event("run", InputKind.RUN, Action.STEP, 1e6) for _ in range(3)))
    stream.events()
    assert run.take_steps() == 1_000_000

    # What was removed or replaced is not declared again by its value.
    gain.remove()
    raises(fire3dv.StateError, lambda: setattr(gain, "value", 1), "'gain' was removed")
    newer = stream.controls.slider("gain", 0, 1)
    raises(fire3dv.StateError, lambda: setattr(gain, "value", 1), "declared again")
    gain.remove()
    newer.value = 0.5
    assert stream.controls["gain"] is newer

    renderer.act(*itertools.repeat(event("fails", InputKind.BUTTON, Action.PRESS), 2000))
    fails.remove()
    presses = stream.controls.button("fails")
    assert len(stream.events()) == 1024 and len(stream.events()) == 976 and presses.presses == 2000
    renderer.events = itertools.repeat(event("fails", InputKind.BUTTON, Action.PRESS))
    assert len(stream.events()) == 1024
print("passed")
