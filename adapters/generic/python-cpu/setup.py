"""A wheel of one platform and of every Python 3. FIRE3DV_WHEEL_PLATFORM: its platform tag."""
import os

from setuptools import Distribution, setup

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # before setuptools 70
    from wheel.bdist_wheel import bdist_wheel


class OfOnePlatform(Distribution):
    def has_ext_modules(self):
        return True


class OfEveryPython(bdist_wheel):
    def get_tag(self):
        return "py3", "none", os.environ.get("FIRE3DV_WHEEL_PLATFORM") or super().get_tag()[2]


setup(cmdclass={"bdist_wheel": OfEveryPython}, distclass=OfOnePlatform)
