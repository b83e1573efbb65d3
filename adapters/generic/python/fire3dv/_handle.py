"""Owner of a C stream: makes it impossible to call the library with a stream that another thread has closed."""
import os
import threading
from ctypes import byref, c_void_p
from typing import Any, List

from ._library import library
from .errors import ErrorCode, StateError


class StreamHandle:
    """A C stream, and the calls in progress on it. The library lets calls of several threads exclude each other."""

    def __init__(self, stream: c_void_p) -> None:
        self._stream = stream
        self._owner = os.getpid()
        #: Held while more than one call makes up one operation. Reentrant, for handlers of signals.
        self.lock = threading.RLock()
        self._changed = threading.Condition(self.lock)
        self._callers: List[int] = []  # threads
        self._is_closing = False

    @property
    def is_open(self) -> bool:
        return bool(self._stream) and not self._is_closing

    @property
    def is_inherited(self) -> bool:
        """Whether this process was forked from that of the stream. It must not touch its locks then, which threads may
        hold that this process lacks."""
        return os.getpid() != self._owner

    @property
    def stream(self) -> c_void_p:
        """The C stream. Raises StateError."""
        self._check()
        return self._stream

    def _check(self) -> None:
        if not self.is_open:
            raise StateError(ErrorCode.STATE, "the stream is closed")
        if self.is_inherited:
            raise StateError(ErrorCode.STATE, f"the stream belongs to process {self._owner}, from which this one was "
                             "forked: open a stream in this process")

    def call(self, function: Any, *arguments: Any) -> int:
        """Calls a function of the library, with the stream before the arguments. Returns its code."""
        self._check()
        caller = threading.get_ident()
        with self.lock:
            self._check()
            self._callers.append(caller)
        try:
            return int(function(self._stream, *arguments))
        finally:
            with self.lock:
                self._callers.remove(caller)
                self._free_if_unused()

    def close(self) -> None:
        """Frees the stream after the calls in progress. In a forked child the parent's stream goes on."""
        if self.is_inherited:
            self._is_closing = True
            library().fire3dv_close(byref(self._stream))
            return
        with self.lock:
            self._is_closing = True
            self._free_if_unused()
            # Not for a call of this thread, which a signal handler has interrupted: that frees the stream.
            while self._stream and threading.get_ident() not in self._callers:
                self._changed.wait()

    def _free_if_unused(self) -> None:
        if self._is_closing and not self._callers and self._stream:
            library().fire3dv_close(byref(self._stream))
            self._changed.notify_all()
