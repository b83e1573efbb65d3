"""Build step that copies the client library of this source tree into the package.

FIRE3DV_CLIENT_LIBRARY in the environment names another one; empty, it leaves the library out.
"""
import os
import runpy
import shutil

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGE = os.path.join(HERE, "fire3dv")
PLACES = runpy.run_path(os.path.join(PACKAGE, "_places.py"))


def library():
    named = os.environ.get("FIRE3DV_CLIENT_LIBRARY")
    if named is not None:
        return named or None
    return next(iter(PLACES["in_build_trees"](PACKAGE)), None)


class WithLibrary(build_py):
    def run(self):
        super().run()
        if library():
            shutil.copyfile(library(), os.path.join(self.build_lib, "fire3dv", PLACES["FILE_NAME"]))


class OfOnePlatform(Distribution):
    def has_ext_modules(self):
        return library() is not None


setup(cmdclass={"build_py": WithLibrary}, distclass=OfOnePlatform)
