"""Renderer processes: the program fire3dv, started and stopped by Python."""
from __future__ import annotations

import ctypes
import os
import re
import secrets
import shutil
import sys
import tempfile
import time
import weakref
from typing import Dict, List, Mapping, Optional, Sequence, TextIO, Tuple, Union

from ._library import library_file
from ._numbers import real, whole
from ._process import GuardedProcess
from ._programs import environment_of
from ._scene_names import InstanceList, SceneNames
from .errors import ArgumentError, Error, ErrorCode, LibraryNotFound, RendererError, RendererNotFound, StateError
from .stream import Stream

PROGRAM_NAME = "fire3dv"
_QUOTED_LINES = 12
_LISTENING = re.compile(r"listening on (\S+)$")
_LINK = re.compile(r"\s*(control|view)\s+(https?://\S+#\S+)$")
_HEADLESS = re.compile(r"\buse --headless( --frames 1 --out DIR)?")

_ANY_PORT = "127.0.0.1:0"

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
                 environment: Optional[Mapping[str, str]] = None, log: Optional[TextIO] = None,
                 start_timeout_s: float = 120.0, serve: Union[bool, str] = False, require_gpu: bool = False) -> None:
        """Starts the program fire3dv and waits until it listens.

        scene: glTF file or robot description. uri: None for shared memory with a fresh name; "tcp://127.0.0.1:0"
        takes a free port. headless: False opens a window. on_request: without a window, only requested images are
        drawn. size: (width, height) in pixels of the window, or of images that arguments write. camera: name. device: index,
        name, "cuda:N" as CUDA and PyTorch number it, "uuid:HEX" or "pci:ADDRESS". require_gpu: an error where no GPU can
        draw, instead of images drawn by the CPU.
        arguments: further options of fire3dv(1). program: see find_program. environment: variables of the process;
        None: those of this one. log: text file for the renderer's messages, such as sys.stderr.
        serve: True for a live view in browsers of this machine, at a free port; "127.0.0.1:8080" for this one. view_link
        and fire3dv.show lead there.
        """
        uri = f"shm://python-{os.getpid()}-{secrets.token_hex(6)}" if uri is None else uri
        self.scene = os.fspath(scene)  #: as given
        self.program = find_program(program)
        scene_argument = os.path.join(os.curdir, self.scene) if self.scene.startswith("-") else self.scene
        command = [self.program, scene_argument, "--listen", uri]
        if headless:
            command += ["--headless", *(["--on-request"] if on_request else [])]
        if not isinstance(serve, (bool, str)):
            raise ArgumentError(ErrorCode.ARGUMENT, f"serve is {serve!r}; True, False or \"HOST:PORT\" is needed")
        if serve:
            command += ["--serve", _ANY_PORT if serve is True else serve]
        command += ["--require-gpu"] if require_gpu else []
        if size is not None:
            command += ["--size", self._size_text(size)]
        for option, value in (("--camera", camera), ("--device", device)):
            command += [option, str(value)] if value is not None else []
        if isinstance(arguments, (str, bytes)):
            raise ArgumentError(ErrorCode.ARGUMENT, f"arguments is one {type(arguments).__name__}; a list is needed, such "
                                "as [\"--samples\", \"1\"]")
        command += [os.fspath(argument) for argument in arguments]
        self._serves = any(word == "--serve" or str(word).startswith("--serve=") for word in command)
        timeout_s = real(start_timeout_s, "start_timeout_s")
        for text in (uri, *command):
            if not isinstance(text, str) or "\0" in text:
                raise ArgumentError(ErrorCode.ARGUMENT, f"{text!r} is not an argument of a program: use a str without NUL")
        folder = tempfile.mkdtemp(prefix="fire3dv-")
        self.instances = InstanceList(os.path.join(folder, "instances.jsonl"))  # for Image.names
        if not any(word == "--instances" or word.startswith("--instances=") for word in command):
            command += ["--instances", self.instances.path]
        try:
            self._process = GuardedProcess(command, environment_of(self.program, environment), log, folder)
        except OSError as fault:
            shutil.rmtree(folder, ignore_errors=True)
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
        """Returns the URI. Sets the links of the live view, which the renderer prints after it."""
        end = time.monotonic() + timeout_s
        self._links: Dict[str, str] = {}
        uri = None
        while True:
            status = self._process.exit_status()  # before the lines: output from before its end counts
            for line in self._process.lines():
                listening, link = _LISTENING.search(line), _LINK.match(line)
                if listening and uri is None:
                    uri = listening.group(1)
                if link:
                    self._links[link.group(1)] = link.group(2)
            if uri is not None and ("view" in self._links or not self._serves):
                return uri
            if status is not None:
                raise self._error(f"{_ended(status)} before it listened")
            if time.monotonic() >= end:
                missing = "does not listen" if uri is None else "prints no link of its live view"
                raise self._error(f"{missing} after {timeout_s:g} s (start_timeout_s)")
            self._process.wait_for_output(min(0.1, timeout_s))

    def _error(self, event: str) -> Error:
        lines = self._process.lines()[-_QUOTED_LINES:]
        quoted = _HEADLESS.sub("use headless=True", "\n".join(f"    {line}" for line in lines))
        said = f". Its last lines:\n{quoted}" if lines else "; it wrote nothing"
        return RendererError(ErrorCode.SYSTEM, f"the renderer {self.program} {event}{said}")

    @property
    def pid(self) -> int:
        """Number of the renderer's process."""
        return self._process.pid

    @property
    def is_running(self) -> bool:
        """Whether the renderer's process has not ended yet."""
        return self._process.exit_status() is None

    @property
    def log(self) -> List[str]:
        """Last lines that the renderer has written."""
        return self._process.lines()

    @property
    def view_link(self) -> str:
        """Link of the live view that looks only: for browsers, and fire3dv.show. Raises StateError without serve."""
        return self._link("view")

    @property
    def control_link(self) -> str:
        """Link of the live view that also changes what all viewers see. Raises StateError without serve."""
        return self._link("control")

    def _link(self, kind: str) -> str:
        if kind not in self._links:
            raise StateError(ErrorCode.STATE, f"the renderer of {self.scene} has no live view: start it by "
                             "fire3dv.Renderer(..., serve=True)")
        return self._links[kind]

    def check(self) -> None:
        """Raises RendererError, with the renderer's last lines, if the process has ended."""
        status = self._process.exit_status()
        if not self._stop.alive:
            raise RendererError(ErrorCode.STATE, f"the renderer of {self.scene} is closed")
        if status is not None:
            raise self._error(_ended(status))

    def stream(self, adapter_name: Optional[str] = None, *, key_file: Optional[str] = None,
               tls_ca_file: Optional[str] = None, tls_certificate_file: Optional[str] = None,
               tls_key_file: Optional[str] = None, scene_budget_bytes: int = 0) -> Stream:
        """Opens a stream to this renderer. Arguments are those of Stream.

        Functions of this stream that wait for images raise RendererError if the renderer ends meanwhile.
        close() of the renderer closes the stream.
        """
        self.check()
        stream = Stream(self.uri, adapter_name, key_file=key_file, tls_ca_file=tls_ca_file,
                        tls_certificate_file=tls_certificate_file, tls_key_file=tls_key_file,
                        scene_budget_bytes=scene_budget_bytes)
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
