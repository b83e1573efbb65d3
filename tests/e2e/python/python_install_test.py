"""Installation test of the Python package: pip installs it from the tree with the library inside, and it runs in place.
Without the library the error names the searched places and the remedy.

python_install_test.py SOURCE_TREE LIBRARY VERSION
"""
import os
import shutil
import subprocess
import sys
import tempfile

tree, library, version = sys.argv[1:]
USE = ("import fire3dv; stream = fire3dv.Stream('udp://127.0.0.1:9'); stream.describe(['a']); "
       "print(fire3dv.version(), fire3dv.__file__)")
WITHOUT = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "FIRE3DV_CLIENT_LIBRARY")}


def python(*arguments, **environment):
    return subprocess.run([sys.executable, *arguments], env={**WITHOUT, **environment}, text=True, capture_output=True,
                          check=False)


with tempfile.TemporaryDirectory() as folder:
    source, target = os.path.join(folder, "source"), os.path.join(folder, "target")
    # Copies the sources: setuptools writes into the source folder.
    shutil.copytree(os.path.join(tree, "adapters", "generic", "python"), source,
                    ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
    done = python("-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-index",
                  "--no-build-isolation", "--target", target, source, FIRE3DV_CLIENT_LIBRARY=library)
    assert done.returncode == 0, done.stderr
    assert os.path.exists(os.path.join(target, "fire3dv", "py.typed"))
    used = python("-c", USE, PYTHONPATH=target)
    assert used.returncode == 0, used.stderr
    assert used.stdout.split() == [version, os.path.join(target, "fire3dv", "__init__.py")], used.stdout
    metadata = python("-c", "import importlib.metadata as m; print(m.version('fire3dv'))", PYTHONPATH=target)
    assert metadata.stdout.strip() == version, "pyproject.toml has another version than CMakeLists.txt"

    for place, text in (("/nowhere/lib.so", "correct FIRE3DV_CLIENT_LIBRARY"), ("libc.so.6", "has no fire3dv_version")):
        wrong = python("-c", "import fire3dv\ntry: fire3dv.version()\nexcept fire3dv.LibraryNotFound as e: print(e)",
                       PYTHONPATH=target, FIRE3DV_CLIENT_LIBRARY=place)
        assert wrong.returncode == 0 and text in wrong.stdout and place in wrong.stdout, (wrong.stdout, wrong.stderr)
print("ok")
