"""Node names of a scene file, in the order of the renderer's instance ids, and of nodes that were added to it."""
import json
import os
import struct
import subprocess
import threading
from typing import IO, Any, Dict, List, Optional, Sequence, Set, Tuple

from ._programs import environment_of
from .errors import ArgumentError, ErrorCode, RendererNotFound

_GLTF = (".glb", ".gltf")
# Options of fire3dv(1) that select the contents of a description file, as options of fire3dv-convert(1).
_CONVERTER_OPTIONS = {"--models": "-l", "--ns": "--ns", "--package-path": "--package-path",
                      "--xacro-arg": "--xacro-arg"}


def _document(data: bytes, scene: str) -> Dict[str, Any]:
    """The JSON of a .glb or .gltf file."""
    try:
        if data[:4] == b"glTF":
            _, _, _, length, kind = struct.unpack_from("<4sIIII", data)
            if kind != 0x4E4F534A:
                raise ValueError("its first chunk is no JSON")
            data = data[20:20 + length]
        document = json.loads(data)
        if not isinstance(document, dict):
            raise ValueError("its JSON is not an object")
        return document
    except (ValueError, struct.error, RecursionError) as fault:
        raise ArgumentError(ErrorCode.ARGUMENT, f"{scene} is no glTF file: {fault}") from None


def _names(document: Dict[str, Any]) -> List[str]:
    """The renderer's order: depth first from the roots of the shown scene.

    GPU instances follow their node. They are nameless in the renderer, and get its name.
    """
    nodes, scenes = document.get("nodes", []), document.get("scenes")
    parents: Dict[int, int] = {child: i for i, node in enumerate(nodes) for child in node.get("children", [])}
    if scenes:
        named = list(dict.fromkeys(scenes[document.get("scene", 0)].get("nodes", [])))
        roots = [node for node in named if not _is_below(node, set(named), parents)]
    else:
        roots = [i for i in range(len(nodes)) if i not in parents]
    names: List[str] = []
    pending = roots[::-1]
    while pending:
        node = nodes[pending.pop()]
        names.append(node.get("name", ""))
        instancing = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
        if instancing and "mesh" in node:
            attributes = instancing["attributes"]
            accessor = next(attributes[kind] for kind in ("TRANSLATION", "ROTATION", "SCALE") if kind in attributes)
            names += [names[-1]] * document["accessors"][accessor]["count"]
        pending += node.get("children", [])[::-1]
    return names


def _is_below(node: int, roots: "set[int]", parents: Dict[int, int]) -> bool:
    for _ in parents:  # a cycle, which the renderer refuses, must not hang
        if node not in parents:
            return False
        node = parents[node]
        if node in roots:
            return True
    return False


def is_gltf(scene: str) -> bool:
    """Whether the renderer reads the file itself."""
    return scene.lower().endswith(_GLTF)


def converted(scene: str, program: str, arguments: Sequence[str], purpose: str) -> bytes:
    """Returns the .glb of a description file. program: the renderer, whose converter is beside it. arguments: of
    fire3dv(1). purpose: for messages."""
    converter = os.path.join(os.path.dirname(program), "fire3dv-convert")
    if not os.access(converter, os.X_OK):
        raise RendererNotFound(ErrorCode.SYSTEM, f"{purpose} of {scene} need {converter}, which is not there: convert "
                               "the scene to .glb by fire3dv-convert, and use that")
    command = [converter, os.path.join(os.curdir, scene) if scene.startswith("-") else scene, "-o", "-"]
    words = [part for word in arguments for part in (word.split("=", 1) if word.startswith("--") else [word])]
    for option, value in zip(words, words[1:]):
        if option in _CONVERTER_OPTIONS:
            command += ["--all"] if (option, value) == ("--models", "all") else [_CONVERTER_OPTIONS[option], value]
    done = subprocess.run(command, env=environment_of(converter, None), stdin=subprocess.DEVNULL, capture_output=True, check=False)
    if done.returncode != 0:
        raise ArgumentError(ErrorCode.ARGUMENT, f"{scene}: {done.stderr.decode('utf-8', 'replace').strip()}")
    return done.stdout


class SceneNames:
    """Names of the nodes of one scene, read on first use."""

    def __init__(self, scene: str, program: Optional[str] = None, arguments: Sequence[str] = ()) -> None:
        self._scene, self._program, self._arguments = scene, program, list(arguments)
        self._names: Optional[List[str]] = None

    def names(self) -> List[str]:
        """Returns the name of instance id i at i - 1; "" for a nameless node."""
        if self._names is None:
            if is_gltf(self._scene):
                with open(self._scene, "rb") as file:
                    data = file.read()
            else:
                if self._program is None:
                    from .renderer import find_program
                    self._program = find_program()
                data = converted(self._scene, self._program, self._arguments, "names")
            try:
                self._names = _names(_document(data, self._scene))
            except (AttributeError, IndexError, KeyError, StopIteration, TypeError) as fault:
                raise ArgumentError(ErrorCode.ARGUMENT, f"{self._scene} is not a valid glTF file: {fault!r}") from None
        return self._names


class InstanceNames:
    """Paths of the nodes of one state of the scene, read on first use from a file of `fire3dv --instances`."""

    def __init__(self, file: IO[str]) -> None:
        self._file: Optional[IO[str]] = file  # open, since the renderer puts another file in its place
        self._paths: Dict[int, str] = {}
        self._lock = threading.Lock()

    def __del__(self) -> None:
        if self._file is not None:
            self._file.close()

    def paths(self) -> Dict[int, str]:
        """Returns the paths by instance id."""
        with self._lock:
            if self._file is not None:
                with self._file as file:
                    entries = map(json.loads, file)
                    self._paths = {int(entry["instance"]): str(entry["path"]) for entry in entries}
                self._file = None
            return self._paths


class InstanceList:
    """File that a renderer keeps up to date with its scene: as of the newest image that it has drawn."""

    _MOST = 3  # states of the scene, of which images on their way may be

    def __init__(self, path: str) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._state: Optional[Tuple[int, int, int]] = None
        self._states: List[InstanceNames] = []

    def current(self, is_newest: bool) -> List[InstanceNames]:
        """Returns the states of the scene that an image that has just come may show. is_newest: it shows the newest frame,
        in lockstep, and thus the newest state."""
        with self._lock:
            try:
                found = os.stat(self.path)
                state = (found.st_ino, found.st_mtime_ns, found.st_size)
                if state != self._state:
                    self._states.append(InstanceNames(open(self.path, encoding="utf-8")))
                    self._states, self._state = self._states[-self._MOST:], state
            except OSError:  # of a renderer that has ended, or has other options
                pass
            return self._states[-1:] if is_newest else list(self._states)


def agreed_paths(states: Sequence[InstanceNames], numbers: Sequence[int]) -> Dict[int, str]:
    """Returns the paths of these instances, without those that differ between the states."""
    found: Dict[int, Set[str]] = {}
    for state in states:
        paths = state.paths()
        for number in numbers:
            if number in paths:
                found.setdefault(number, set()).add(paths[number])
    return {number: paths.pop() for number, paths in found.items() if len(paths) == 1}
