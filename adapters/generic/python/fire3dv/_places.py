"""Search paths of the client library. Imports nothing of the package: setup.py loads this file alone."""
import glob
import os
from typing import List

FILE_NAME = "libfire3dv-client.so.0"


def in_build_trees(package: str) -> List[str]:
    """Libraries built from the source tree of this package, newest first."""
    root = os.path.normpath(os.path.join(package, *[os.pardir] * 4))
    if os.path.join(root, "adapters", "generic", "python", "fire3dv") != os.path.normpath(package):
        return []
    found = [path for folder in ("build", "build/*", "build-*") for library in ("lib*", "lib/*")
             for path in glob.glob(os.path.join(glob.escape(root), folder, library, FILE_NAME))]
    return sorted(found, key=os.path.getmtime, reverse=True)


def all_places(package: str) -> List[str]:
    """Existing library files, in order of preference."""
    prefix = os.path.normpath(os.path.join(package, *[os.pardir] * 4))  # PREFIX/share/fire3dv/python/fire3dv
    found = [os.path.join(package, FILE_NAME)]
    if os.path.join(prefix, "share", "fire3dv", "python", "fire3dv") == os.path.normpath(package):
        escaped = glob.escape(prefix)
        found += glob.glob(os.path.join(escaped, "lib*", FILE_NAME))
        found += glob.glob(os.path.join(escaped, "lib", "*", FILE_NAME))
    return [path for path in found if os.path.exists(path)] + in_build_trees(package)
