"""Frames of a simulator whose time may jump back."""
from __future__ import annotations

from typing import Optional

from ._types import Array
from .stream import FRAME_DISCONTINUITY, Stream


class FrameSequence:
    """Publishes frames to a stream. The first one, and one whose time is before that of the last, is a discontinuity."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._last_ns: Optional[int] = None

    def publish(self, sim_time_ns: int, poses: Array) -> int:
        """Returns the sequence. Does not block."""
        jumped = self._last_ns is None or sim_time_ns < self._last_ns
        sequence = self._stream.publish(sim_time_ns, poses, FRAME_DISCONTINUITY if jumped else 0)
        self._last_ns = sim_time_ns
        return sequence

    def jump(self) -> None:
        """Makes the next frame a discontinuity."""
        self._last_ns = None
