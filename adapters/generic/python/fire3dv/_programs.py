"""Programs of the wheel: started by the scripts that pip puts on the PATH, and by Renderer, with libraries and drivers
that the system lacks."""
import ctypes
import glob
import importlib.util
import os
from typing import Dict, Mapping, Optional

PACKAGE = os.path.dirname(os.path.abspath(__file__))
PROGRAMS = os.path.join(PACKAGE, "bin")
# Libraries that the system has, or that lie in lib/GROUP: the first one decides for its group.
FALLBACKS = {"stdcxx": "libstdc++.so.6", "vulkan": "libvulkan.so.1", "x11": "libX11.so.6", "xext": "libXext.so.6",
             "glvnd": "libEGL.so.1"}
STDCXX_SYMBOLS = b"GLIBCXX_3.4.30"  # the newest that the programs need: GCC 12
LOADER_VERSION = (1, 3, 207)  # the Vulkan loader that reads VK_ADD_DRIVER_FILES


def _loaded_file(name: str) -> str:
    """File of a library that this process has loaded; "": unknown."""
    try:
        with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
            return next((line.split(maxsplit=5)[5].strip() for line in maps if os.path.basename(line.strip()).startswith(name)), "")
    except OSError:
        return ""


def _is_usable(group: str, name: str) -> bool:
    try:
        library = ctypes.CDLL(name)
    except OSError:
        return False
    if group == "stdcxx":
        try:
            with open(_loaded_file(name), "rb") as file:
                return STDCXX_SYMBOLS in file.read()
        except OSError:
            return True
    if group == "vulkan":
        version = ctypes.c_uint32()
        try:
            library.vkEnumerateInstanceVersion(ctypes.byref(version))
        except AttributeError:
            return False
        number = version.value
        return (number >> 22, number >> 12 & 1023, number & 4095) >= LOADER_VERSION
    return True


def software_driver() -> Optional[str]:
    """Manifest of the software driver of the package fire3dv-cpu; None if that is not installed."""
    found = importlib.util.find_spec("fire3dv_cpu")
    if found is None or not found.submodule_search_locations:
        return None
    manifest = os.path.join(found.submodule_search_locations[0], "lib", "lvp_icd.json")
    return manifest if os.path.exists(manifest) else None


def environment(base: Optional[Mapping[str, str]] = None) -> Dict[str, str]:
    """Variables of a program of this package: base, or those of this process, and the search paths of what the system lacks."""
    variables = dict(os.environ if base is None else base)
    folders = [folder for group, name in FALLBACKS.items()
               for folder in glob.glob(os.path.join(glob.escape(PACKAGE), "lib", group)) if not _is_usable(group, name)]
    if folders:
        variables["LD_LIBRARY_PATH"] = os.pathsep.join([*filter(None, [variables.get("LD_LIBRARY_PATH")]), *folders])
    driver = software_driver()
    if driver and not any(variables.get(name) for name in ("VK_DRIVER_FILES", "VK_ICD_FILENAMES")):
        # Added to the system's drivers: the renderer takes the first device that can draw, GPUs first.
        variables["VK_ADD_DRIVER_FILES"] = os.pathsep.join([*filter(None, [variables.get("VK_ADD_DRIVER_FILES")]), driver])
    return variables


def environment_of(program: str, base: Optional[Mapping[str, str]]) -> Optional[Mapping[str, str]]:
    """environment(base) for a program of this package, base for any other."""
    return environment(base) if os.path.dirname(os.path.abspath(program)) == PROGRAMS else base


def path_of(name: str) -> str:
    """A program of this package; of an installation without programs, the one beside the renderer that find_program finds."""
    inside = os.path.join(PROGRAMS, name)
    if os.path.exists(inside):
        return inside
    from .renderer import find_program
    return os.path.join(os.path.dirname(find_program()), name)
