"""Build step that copies the client library, the renderer and the converter of this source tree into the package.

FIRE3DV_CLIENT_LIBRARY in the environment names another library, FIRE3DV another renderer; empty, they leave it out.
FIRE3DV_WHEEL_FILES is a folder whose contents go into the package: programs in bin, their libraries in lib.
FIRE3DV_WHEEL_PLATFORM is the platform tag of a wheel; without it, the tag is that of this machine's own programs. All
intermediate files are in a temporary folder: the source tree stays clean.
"""
import atexit
import os
import runpy
import shutil
import sys
import tempfile

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # before setuptools 70
    from wheel.bdist_wheel import bdist_wheel

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGE = os.path.join(HERE, "fire3dv")
PLACES = runpy.run_path(os.path.join(PACKAGE, "_places.py"))
CONVERTER = "fire3dv-convert"  # the renderer looks for it in its own folder


def library():
    named = os.environ.get("FIRE3DV_CLIENT_LIBRARY")
    if named is not None:
        return named or None
    return next(iter(PLACES["in_build_trees"](PACKAGE)), None)


def wheel_files():
    return os.environ.get("FIRE3DV_WHEEL_FILES")


def commands():
    """Entry points of the programs in the package: scripts that pip puts on the PATH."""
    names = os.listdir(os.path.join(wheel_files(), "bin")) if wheel_files() else map(os.path.basename, programs())
    return [f"{name} = fire3dv.__main__:main" for name in sorted(names)]


def programs():
    """Renderer and converter, of the build that the library is from."""
    named = os.environ.get("FIRE3DV")
    if named is not None:
        renderer = named
    else:
        renderer = os.path.join(os.path.dirname(library()), os.pardir, "bin", "fire3dv") if library() else ""
    found = [renderer, os.path.join(os.path.dirname(renderer), CONVERTER)] if renderer else []
    return [program for program in found if os.access(program, os.X_OK)]


class WithPrograms(build_py):
    def run(self):
        super().run()
        package = os.path.join(self.build_lib, "fire3dv")
        if library():
            shutil.copyfile(library(), os.path.join(package, PLACES["FILE_NAME"]))
        if wheel_files():
            shutil.copytree(wheel_files(), package, dirs_exist_ok=True)
        for program in programs():
            os.makedirs(os.path.join(package, "bin"), exist_ok=True)
            shutil.copy(program, os.path.join(package, "bin", os.path.basename(program)))


class OfOnePlatform(Distribution):
    def has_ext_modules(self):
        return bool(library() or programs() or wheel_files())


class OfEveryPython(bdist_wheel):
    def get_tag(self):
        """ctypes loads the library: the wheel is of one platform and of every Python 3."""
        platform = super().get_tag()[2]
        return "py3", "none", os.environ.get("FIRE3DV_WHEEL_PLATFORM") or platform


def in_temporary_folder():
    """Options of setuptools' commands, which write into the source tree otherwise."""
    if "develop" in sys.argv:  # links to the source tree
        return {}
    folder = tempfile.mkdtemp(prefix="fire3dv-build-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    options = {"build": {"build_base": folder}, "egg_info": {"egg_base": folder}}
    if "FIRE3DV_WHEEL_PLATFORM" in os.environ:  # tools/wheel.py packs the wheel anew
        options["bdist_wheel"] = {"compression": "stored"}
    return options


setup(entry_points={"console_scripts": commands()}, cmdclass={"build_py": WithPrograms, "bdist_wheel": OfEveryPython},
      distclass=OfOnePlatform, options=in_temporary_folder())
