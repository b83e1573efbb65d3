"""Renderer processes: the program fire3dv, started and stopped by Python."""
from __future__ import annotations

import ctypes
import os
import re
import secrets
import shutil
import sys
import time
import weakref
from typing import Any, List, Mapping, Optional, Sequence, Tuple, Union

from ._library import library_file
from ._numbers import real, whole
from ._process import GuardedProcess
from ._scene_names import SceneNames
from .errors import ArgumentError, Error, ErrorCode, LibraryNotFound, RendererError, RendererNotFound
from .stream import Stream

PROGRAM_NAME = "fire3dv"
_QUOTED_LINES = 12
_LISTENING = re.compile(r"listening on (\S+)$")

Path = Union[str, "os.PathLike[str]"]


def find_program(program: Optional[Path] = None) -> str:
    """Returns the path of the renderer program.

    program: file, or name that PATH finds. None: the environment variable FIRE3DV and then nowhere else; the package's
    folder bin; the folder bin of the client library's build or installation; beside the Python interpreter; PATH.
    """
    named = os.fspath(program) if program is not None else os.environ.get("FIRE3DV")
    if named:
        source = "program" if program is not None else "the environment variable FIRE3DV"
        found = shutil.which(named)
        if found is None:
            raise RendererNotFound(ErrorCode.SYSTEM, f"{source} is {named!r}, which is not an executable file: correct it")
        return os.path.abspath(found)
    package = os.path.dirname(os.path.abspath(__file__))
    folders = [os.path.join(package, "bin")]
    try:
        beside = os.path.dirname(library_file())
        folders += [os.path.join(beside, *up, "bin") for up in ((os.pardir,), (os.pardir, os.pardir))]
    except LibraryNotFound:
        pass
    folders.append(os.path.dirname(sys.executable or "/usr/bin/python3"))
    places = [os.path.normpath(os.path.join(folder, PROGRAM_NAME)) for folder in folders]
    for place in places:
        if shutil.which(place):
            return place
    found = shutil.which(PROGRAM_NAME)
    if found is None:
        raise RendererNotFound(
            ErrorCode.SYSTEM, f"the program {PROGRAM_NAME} is neither on the PATH nor at {', '.join(places)}: build or "
            "install it, or set the environment variable FIRE3DV to its file")
    return os.path.abspath(found)


def _ended(status: int) -> str:
    return f"was ended by signal {-status}" if status < 0 else f"ended with exit status {status}"


class Renderer:
    """A renderer process that listens for a stream, without a window by default.

        with fire3dv.Renderer("scene.glb") as renderer, renderer.stream() as stream:
            stream.describe(["arm"])

    The process is running and listening when the constructor returns. It ends with close(), the with statement, this
    object or this process, however that ends. Ctrl-C does not reach it.
    """

    def __init__(self, scene: Path, *, uri: Optional[str] = None, headless: bool = True, on_request: bool = True,
                 size: Optional[Tuple[int, int]] = None, camera: Optional[str] = None, device: Optional[str] = None,
                 arguments: Sequence[Path] = (), program: Optional[Path] = None,
                 environment: Optional[Mapping[str, str]] = None, log: Optional[Any] = None,
                 start_timeout_s: float = 120.0) -> None:
        """Starts the program fire3dv and waits until it listens.

        scene: glTF file or robot description. uri: None for shared memory with a fresh name; "tcp://127.0.0.1:0"
        takes a free port. headless: False opens a window. on_request: without a window, only requested images are
        drawn. size: (width, height) in pixels of the window, or of images that arguments write. camera, device: names.
        arguments: further options of fire3dv(1). program: see find_program. environment: variables of the process;
        None: those of this one. log: text file for the renderer's messages, such as sys.stderr.
        """
        uri = f"shm://python-{os.getpid()}-{secrets.token_hex(6)}" if uri is None else uri
        self.scene = os.fspath(scene)  #: as given
        self.program = find_program(program)
        scene_argument = os.path.join(os.curdir, self.scene) if self.scene.startswith("-") else self.scene
        command = [self.program, scene_argument, "--listen", uri]
        if headless:
            command += ["--headless", *(["--on-request"] if on_request else [])]
        if size is not None:
            command += ["--size", self._size_text(size)]
        for option, value in (("--camera", camera), ("--device", device)):
            command += [option, str(value)] if value is not None else []
        command += [os.fspath(argument) for argument in arguments]
        timeout_s = real(start_timeout_s, "start_timeout_s")
        for text in (uri, *command):
            if not isinstance(text, str) or "\0" in text:
                raise ArgumentError(ErrorCode.ARGUMENT, f"{text!r} is not an argument of a program: use a str without NUL")
        try:
            self._process = GuardedProcess(command, environment, log)
        except OSError as fault:
            raise RendererError(ErrorCode.SYSTEM, f"{self.program} cannot be started: {fault}") from None
        self.scene_names = SceneNames(self.scene, self.program, [os.fspath(argument) for argument in arguments])
        self._stop = weakref.finalize(self, self._process.stop)
        self._streams: "weakref.WeakSet[Stream]" = weakref.WeakSet()
        try:
            self.uri = self._wait_until_listening(timeout_s)  #: where the renderer listens
        except BaseException:  # Ctrl-C included
            self._stop()
            raise

    @staticmethod
    def _size_text(size: Tuple[int, int]) -> str:
        try:
            width, height = size
        except (TypeError, ValueError):
            raise ArgumentError(ErrorCode.ARGUMENT, f"size is {size!r}; (width, height) is needed") from None
        return "x".join(str(whole(side, ctypes.c_uint32, "size")) for side in (width, height))

    def _wait_until_listening(self, timeout_s: float) -> str:
        end = time.monotonic() + timeout_s
        while True:
            status = self._process.exit_status()  # before the lines: output from before its end counts
            for line in self._process.lines():
                found = _LISTENING.search(line)
                if found:
                    return found.group(1)
            if status is not None:
                raise self._error(f"{_ended(status)} before it listened")
            if time.monotonic() >= end:
                raise self._error(f"does not listen after {timeout_s:g} s (start_timeout_s)")
            self._process.wait_for_output(min(0.1, timeout_s))

    def _error(self, event: str) -> Error:
        lines = self._process.lines()[-_QUOTED_LINES:]
        said = "; it wrote nothing" if not lines else ". Its last lines:\n" + "\n".join(f"    {line}" for line in lines)
        return RendererError(ErrorCode.SYSTEM, f"the renderer {self.program} {event}{said}")

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def is_running(self) -> bool:
        return self._process.exit_status() is None

    @property
    def log(self) -> List[str]:
        """Last lines that the renderer has written."""
        return self._process.lines()

    def check(self) -> None:
        """Raises RendererError, with the renderer's last lines, if the process has ended."""
        status = self._process.exit_status()
        if not self._stop.alive:
            raise RendererError(ErrorCode.STATE, f"the renderer of {self.scene} is closed")
        if status is not None:
            raise self._error(_ended(status))

    def stream(self, adapter_name: Optional[str] = None, **options: Any) -> Stream:
        """Opens a stream to this renderer. options: those of Stream.

        Functions of this stream that wait for images raise RendererError if the renderer ends meanwhile.
        close() of the renderer closes the stream.
        """
        self.check()
        stream = Stream(self.uri, adapter_name, **options)
        stream.renderer = self
        self._streams.add(stream)
        return stream

    def close(self) -> None:
        """Closes the streams that stream() has opened, and ends the process. May be called repeatedly."""
        try:
            for stream in list(self._streams):
                stream.close()
        finally:
            self._stop()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if not self._stop.alive else "running" if self.is_running else "ended"
        return f"<fire3dv.Renderer of {self.scene!r} at {self.uri}, pid {self.pid}, {state}>"
