"""Installation test of the Python package: pip installs it from the tree into a virtual environment, with the library and
the renderer inside, leaves the tree as it was, and the package runs there. Without the library the error names the searched
places and the remedy.

python_install_test.py SOURCE_TREE LIBRARY VERSION [FIRE3DV]
"""
import os
import shutil
import subprocess
import sys
import tempfile

tree, library, version, *renderer = sys.argv[1:]
USE = ("import fire3dv; stream = fire3dv.Stream('udp://127.0.0.1:9'); stream.describe(['a']); "
       "print(fire3dv.version(), fire3dv.__file__)")
FIND = ("import fire3dv\ntry: print(fire3dv.find_program())\n"
        "except fire3dv.RendererNotFound as e: print('not found')")
OURS = ("PYTHONPATH", "FIRE3DV_CLIENT_LIBRARY", "FIRE3DV")
WITHOUT = {key: value for key, value in os.environ.items() if key not in OURS}
PIP = ("-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-index", "--no-build-isolation")


def run(program, *arguments, **environment):
    return subprocess.run([program, *arguments], env={**WITHOUT, **environment}, text=True, capture_output=True, check=False)


def python(*arguments, **environment):
    return run(sys.executable, *arguments, **environment)


def contents(folder):
    return {os.path.join(where, name): os.stat(os.path.join(where, name)).st_mtime_ns
            for where, _, names in os.walk(folder) for name in names}


with tempfile.TemporaryDirectory() as folder:
    source, target, venv = (os.path.join(folder, name) for name in ("source", "target", "venv"))
    shutil.copytree(os.path.join(tree, "adapters", "generic", "python"), source,
                    ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
    before = contents(source)

    # As the README says for Debian, with the system's NumPy and setuptools in place of a download.
    made = python("-m", "venv", "--system-site-packages", venv)
    assert made.returncode == 0, f"{made.stdout}{made.stderr}: run tools/setup.sh (python3-venv)"
    inside = os.path.join(venv, "bin", "python3")
    done = run(inside, *PIP, source, FIRE3DV_CLIENT_LIBRARY=library)
    assert done.returncode == 0, done.stderr
    assert contents(source) == before, f"pip wrote into the source tree: {sorted(contents(source).items() ^ before.items())}"
    used = run(inside, "-c", USE)
    assert used.returncode == 0, used.stderr
    package = os.path.dirname(used.stdout.split()[1])
    assert used.stdout.split()[0] == version and package.startswith(venv), used.stdout
    assert os.path.exists(os.path.join(package, "py.typed"))
    metadata = run(inside, "-c", "import importlib.metadata as m; print(m.version('fire3dv'))")
    assert metadata.stdout.strip() == version, "pyproject.toml has another version than CMakeLists.txt"
    if renderer:
        found = run(inside, "-c", FIND)
        assert found.stdout.strip() == os.path.join(package, "bin", "fire3dv"), (found.stdout, found.stderr)
        for program in ("fire3dv", "fire3dv-convert"):
            ran = run(os.path.join(package, "bin", program), "--version" if program == "fire3dv" else "--help")
            assert ran.returncode == 0, (program, ran.stderr)

    # Without the renderer, into a folder.
    done = python(*PIP, "--target", target, source, FIRE3DV_CLIENT_LIBRARY=library, FIRE3DV="")
    assert done.returncode == 0, done.stderr
    assert contents(source) == before, "pip wrote into the source tree"
    assert not os.path.exists(os.path.join(target, "fire3dv", "bin")), "the renderer was installed against FIRE3DV"
    used = python("-c", USE, PYTHONPATH=target)
    assert used.stdout.split() == [version, os.path.join(target, "fire3dv", "__init__.py")], (used.stdout, used.stderr)
    found = python("-c", FIND, PYTHONPATH=target, PATH="/nowhere")
    assert found.stdout.strip() == "not found" or os.path.dirname(found.stdout) == os.path.dirname(sys.executable), found

    # The dynamic linker finds the library: the renderer is looked for where that is, not relative to the current folder.
    here, decoy = os.path.join(folder, "a", "b"), os.path.join(folder, "a", "bin", "fire3dv")
    for directory in (here, os.path.dirname(decoy)):
        os.makedirs(directory)
    with open(decoy, "w", encoding="utf-8") as script:
        script.write("#!/bin/sh\n")
    os.chmod(decoy, 0o755)
    found = python("-c", f"import os; os.chdir({here!r})\n{FIND}", PYTHONPATH=source, LD_LIBRARY_PATH=os.path.dirname(library))
    assert found.returncode == 0 and found.stdout.strip() != decoy, (found.stdout, found.stderr)
    assert not renderer or os.path.samefile(found.stdout.strip(), renderer[0]), (found.stdout, found.stderr)

    for place, text in (("/nowhere/lib.so", "correct FIRE3DV_CLIENT_LIBRARY"), ("libc.so.6", "has no fire3dv_version")):
        wrong = python("-c", "import fire3dv\ntry: fire3dv.version()\nexcept fire3dv.LibraryNotFound as e: print(e)",
                       PYTHONPATH=target, FIRE3DV_CLIENT_LIBRARY=place)
        assert wrong.returncode == 0 and text in wrong.stdout and place in wrong.stdout, (wrong.stdout, wrong.stderr)
print("ok")
