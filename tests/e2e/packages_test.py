"""Packages test: tools/package.sh packs this build; the packages are unpacked into a folder, and used there. Files, control
fields, search paths, renderer, client library (pkg-config, CMake, shared and static), Python package, wheel, completions, desktop
files, service. Validators that are not installed are named and skipped.

packages_test.py SOURCE BUILD VERSION MULTIARCH [mujoco] [drake] [ros2] [gazebo]
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

source, build, version, multiarch, *optional = sys.argv[1:]
PROGRAMS = {"fire3dv": ["fire3dv", "fire3dv-convert", "fire3dv-inspect", "fire3dv-record", "fire3dv-replay"],
            "fire3dv-examples": ["bullet_arm"], **{f"fire3dv-{name}": [f"fire3dv-{name}"] for name in optional}}
LIB = f"usr/lib/{multiarch}"
FILES = {  # beside programs, their manual pages and completions, copyright and changelog
    "fire3dv": ["usr/share/man/man1/fire3dv-render.1.gz", "usr/share/man/man1/fire3dv-doctor.1.gz", "usr/share/man/man1/fire3dv-dataset.1.gz", "usr/share/man/man1/fire3dv-relabel.1.gz", "usr/share/man/man1/fire3dv-verify.1.gz", "usr/share/doc/fire3dv/changelog.gz", "usr/share/doc/fire3dv/NOTICE",
                "usr/share/doc/fire3dv/README.md",
                "usr/share/applications/fire3dv.desktop", "usr/share/applications/fire3dv-recording.desktop",
                "usr/share/mime/packages/fire3dv.xml", "usr/share/metainfo/org.fire3dv.fire3dv.metainfo.xml",
                "usr/lib/systemd/user/fire3dv@.service", "usr/share/icons/hicolor/scalable/apps/fire3dv.svg",
                "usr/share/icons/hicolor/128x128/apps/fire3dv.png",
                *["usr/share/doc/fire3dv/docs/" + os.path.basename(path) for path in glob.glob(source + "/docs/*.md")],
                *[f"usr/share/doc/fire3dv/{name}.md" for name in ("SPEC", "SPEC-transport", "SPEC-record")]],
    "fire3dv-examples": [],
    "fire3dv-mujoco": [],
    "fire3dv-drake": [],
    "fire3dv-gazebo": [],
    "fire3dv-ros2": [],
    "libfire3dv-client0": [f"{LIB}/libfire3dv-client.so.0", f"{LIB}/libfire3dv-client.so.{version}",
                           "usr/share/lintian/overrides/libfire3dv-client0"],
    "libfire3dv-client-dev": [
        f"{LIB}/libfire3dv-client.so", f"{LIB}/libfire3dv-client.a", f"{LIB}/pkgconfig/fire3dv-client.pc",
        *[f"{LIB}/cmake/fire3dv/fire3dv-{name}.cmake" for name in ("config", "config-version", "targets", "targets-release")],
        *["usr/share/doc/libfire3dv-client-dev/" + os.path.relpath(path, source) for path in
          glob.glob(source + "/examples/client_c*/*")],
        *["usr/include/fire3dv/" + os.path.basename(path) for path in glob.glob(source + "/adapters/generic/include/fire3dv/*")]],
    "python3-fire3dv": [f"usr/lib/python3/dist-packages/fire3dv-{version}.dist-info/METADATA",
                        "usr/share/doc/python3-fire3dv/README.md", "usr/lib/python3/dist-packages/fire3dv/py.typed",
                        *["usr/lib/python3/dist-packages/" + os.path.relpath(path, os.path.join(source, "adapters/generic/python"))
                          for path in glob.glob(os.path.join(source, "adapters/generic/python/fire3dv/**/*.py"), recursive=True)]],
}
DEPENDS = {"fire3dv": ["libvulkan1", "libc6"], "fire3dv-examples": ["libfire3dv-client0", "libbullet"],
           "fire3dv-drake": ["libvulkan1"], "fire3dv-gazebo": ["libfire3dv-client0", "libzmq5", "libprotobuf-lite"],
           "fire3dv-mujoco": ["libfire3dv-client0", "libmujoco"], "fire3dv-ros2": ["libfire3dv-client0", "libddsc0"],
           "libfire3dv-client0": ["libssl3", "libsodium23"],
           "libfire3dv-client-dev": ["libfire3dv-client0"], "python3-fire3dv": ["libfire3dv-client0", "python3-numpy"]}
CONTROL = {"libfire3dv-client0": {"triggers", "shlibs"}, "python3-fire3dv": {"postinst", "prerm"}}


def run(*command, cwd=None, **environment):
    done = subprocess.run(command, text=True, capture_output=True, check=False, cwd=cwd, env={**CLEAN, **environment})
    assert done.returncode == 0, f"{' '.join(command)} ended with {done.returncode}:\n{done.stdout}{done.stderr}"
    return done.stdout


CLEAN = {name: value for name, value in os.environ.items()
         if name not in ("PYTHONPATH", "LD_LIBRARY_PATH", "FIRE3DV", "FIRE3DV_CLIENT_LIBRARY")}


def check_package(package, name):
    """Files and control fields of one package."""
    found = {line.split(maxsplit=5)[5].split(" -> ")[0][2:] for line in run("dpkg-deb", "-c", package).splitlines()
             if not line.startswith("d")}
    expected = {*FILES[name], f"usr/share/doc/{name}/copyright", f"usr/share/doc/{name}/changelog.Debian.gz"}
    for program in PROGRAMS.get(name, []):
        expected |= {f"usr/bin/{program}", f"usr/share/man/man1/{program}.1.gz",
                     f"usr/share/bash-completion/completions/{program}", f"usr/share/zsh/vendor-completions/_{program}",
                     f"usr/share/fish/vendor_completions.d/{program}.fish"}
    assert found == expected, f"{name}: missing {sorted(expected - found)}, unexpected {sorted(found - expected)}"
    fields = dict(re.findall(r"^([\w-]+): (.*)$", run("dpkg-deb", "-f", package), re.MULTILINE))
    assert re.fullmatch(re.escape(version) + r"(~git\d{8}\.\d{4})?-1\+[a-z0-9.]+", fields["Version"]), fields["Version"]
    for dependency in DEPENDS[name]:
        assert dependency in fields.get("Depends", ""), f"{name} does not depend on {dependency}: {fields.get('Depends')}"
    assert name == "fire3dv-mujoco" or "mujoco" not in fields["Depends"], fields["Depends"]
    if name == "fire3dv":
        for driver in ("mesa-vulkan-drivers | vulkan-icd", "libavcodec"):
            assert driver in fields["Recommends"], fields["Recommends"]
    scripts = set(run("dpkg-deb", "--ctrl-tarfile", package) and os.listdir(control_of(package)))
    assert CONTROL.get(name, set()) <= scripts, f"{name}: control files {sorted(scripts)}"


def control_of(package):
    folder = package + ".control"
    run("dpkg-deb", "-e", package, folder)
    return folder


def elf_files(folder):
    for path in glob.glob(os.path.join(folder, "**"), recursive=True):
        if os.path.isfile(path) and not os.path.islink(path) and open(path, "rb").read(4) == b"\x7fELF":
            yield path


def check_binaries(root):
    """No search path, no symbols for debuggers, no path of the build."""
    files = list(elf_files(root))
    assert len(files) == sum(map(len, PROGRAMS.values())) + 1, files
    for path in files:
        text = run("readelf", "-dSW", path)
        assert "RUNPATH" not in text and "RPATH" not in text, f"{path} has a library search path"
        assert ".symtab" not in text and ".debug_info" not in text, f"{path} is not stripped"
    for path in glob.glob(os.path.join(root, "**"), recursive=True):
        if os.path.isfile(path):
            content = open(path, "rb").read()
            for folder in (source, build):
                assert f"{folder}/".encode() not in content, f"{path} holds the path {folder}"


def check_renderer(root, work):
    programs, libraries = os.path.join(root, "usr/bin"), {"LD_LIBRARY_PATH": os.path.join(root, LIB)}
    for program in sum(PROGRAMS.values(), []):
        assert f"{program} {version} " in run(os.path.join(programs, program), "--version", **libraries)
    run(os.path.join(programs, "bullet_arm"), "--write-scene", "arm.glb", cwd=work, **libraries)
    run(os.path.join(programs, "fire3dv"), "arm.glb", "--headless", "--size", "64x36", "--camera", "camera_front",
        "--frames", "1", "--cache", "off", "--out", "images", cwd=work)
    with open(os.path.join(work, "images/frame_000000.png"), "rb") as image:
        assert image.read(8) == b"\x89PNG\r\n\x1a\n"
    robot = os.path.join(source, "tests/assets/robots/arm_description/urdf/arm.urdf")
    run(os.path.join(programs, "fire3dv-convert"), robot, "--out", "robot.glb", cwd=work)
    assert open(os.path.join(work, "robot.glb"), "rb").read(4) == b"glTF"


def check_client(root, work):
    """The packaged example client_c by pkg-config, with the shared and the static library, and by CMake."""
    example, out = os.path.join(root, "usr/share/doc/libfire3dv-client-dev/examples/client_c"), os.path.join(work, "client")
    shared = os.path.join(root, LIB)
    environment = {"PKG_CONFIG_PATH": os.path.join(shared, "pkgconfig")}
    flags = run("pkg-config", "--cflags", "--libs", "fire3dv-client", **environment).split()
    run("cc", os.path.join(example, "main.c"), "-o", out, *flags, "-lm")
    published = run(out, f"shm://packages-{os.getpid()}", "5", LD_LIBRARY_PATH=shared)
    assert published == "client_c: 5 frames published\n", published
    private = run("pkg-config", "--static", "--cflags", "--libs", "fire3dv-client", **environment).split()
    run("cc", os.path.join(example, "main.c"), "-o", out, *["-l:libfire3dv-client.a" if flag == "-lfire3dv-client" else flag
                                                         for flag in private])
    assert run(out, f"shm://packages-{os.getpid()}", "5") == published
    assert "libfire3dv" not in run("readelf", "-d", out), "the static library is not in the program"

    project = os.path.join(work, "project")
    os.makedirs(project)
    with open(os.path.join(project, "CMakeLists.txt"), "w", encoding="utf-8") as file:
        file.write(f"cmake_minimum_required(VERSION 3.23)\nproject(user LANGUAGES C)\nfind_package(fire3dv {version} REQUIRED)\n"
                   + "".join(f"add_executable({name} {example}/main.c)\ntarget_link_libraries({name} fire3dv::{name} m)\n"
                             for name in ("client", "client_static")))
    run("cmake", "-S", project, "-B", project + "/build", f"-DCMAKE_PREFIX_PATH={root}/usr")
    run("cmake", "--build", project + "/build")
    for name in ("client", "client_static"):
        assert run(f"{project}/build/{name}", f"shm://packages-{os.getpid()}", "5") == published


USE = """
import importlib.metadata, sys, fire3dv
stream = fire3dv.Stream("udp://127.0.0.1:9"); stream.describe(["a"]); stream.publish(0, fire3dv.pose((0, 0, 0), quaternion=(0, 0, 0, 1)))
loaded = {line.split()[-1] for line in open("/proc/self/maps") if "libfire3dv-client" in line}
print(fire3dv.version(), importlib.metadata.version("fire3dv"), *loaded, fire3dv.__file__)
if sys.argv[1:]:
    with fire3dv.Renderer(sys.argv[1]) as renderer, renderer.stream() as stream:
        view = fire3dv.look_at(eye=(2, 1, 2), target=(0, 0.5, 0))
        stream.describe(["a"])
        request = stream.request_image(32, 24, fx=30, parent_from_camera=view)
        stream.publish(0, fire3dv.pose((0, 0, 0), quaternion=(0, 0, 0, 1)))
        image = request.wait()
        print(renderer.program, image.color.shape, image.color[..., :3].std() > 1)
"""


def check_python(root, work, wheel):
    """Python package of the system with the packaged renderer, and the wheel, which needs nothing else."""
    modules, library = os.path.join(root, "usr/lib/python3/dist-packages"), os.path.join(root, LIB, f"libfire3dv-client.so.{version}")
    said = run(sys.executable, "-W", "ignore", "-c", USE, "arm.glb", cwd=work, PYTHONPATH=modules, PYTHONDONTWRITEBYTECODE="1",
               LD_LIBRARY_PATH=os.path.dirname(library))
    assert said.split() == [version, version, library, f"{modules}/fire3dv/__init__.py", f"{root}/usr/bin/fire3dv",
                            "(24,", "32,", "4)", "True"], said

    check_wheel(work, wheel)


WHEEL_PROGRAMS = sorted([*PROGRAMS["fire3dv"], "bullet_arm", *[f"fire3dv-{name}" for name in optional]])
GLIBC = re.compile(r"lib(c|m|dl|pthread|rt|resolv|util)\.so\.\d+|ld-linux[\w.-]*")


def check_wheel(work, wheel):
    """The wheel holds the programs and all that they need but glibc; its commands and its Renderer work."""
    tag = re.fullmatch(rf"fire3dv-{re.escape(version)}-py3-none-manylinux_2_(\d+)_\w+\.whl", os.path.basename(wheel))
    assert tag, f"the wheel is called {wheel}"
    assert os.path.getsize(wheel) < 60e6, f"the wheel has {os.path.getsize(wheel)} bytes"
    folder = os.path.join(work, "wheel")
    run(sys.executable, "-m", "zipfile", "-e", wheel, folder)
    package = os.path.join(folder, "fire3dv")
    libraries = {os.path.basename(path) for path in elf_files(package)}
    for path in elf_files(package):
        text, name = run("readelf", "-dVW", path), os.path.relpath(path, package)
        for library in re.findall(r"\(NEEDED\).*\[(.*)\]", text):
            assert GLIBC.fullmatch(library) or library in libraries, f"{name} needs {library}, which the wheel lacks"
        if not re.match(r"lib/(stdcxx|vulkan|x11|xext|glvnd)/", name):  # these replace libraries that the system lacks
            newest = max(map(int, re.findall(r"Name: GLIBC_2\.(\d+)", text)), default=0)
            assert newest <= int(tag.group(1)), f"{name} needs glibc 2.{newest}, the wheel's tag promises {tag.group(1)}"
    for library in ("xext/libXext.so.6", "glvnd/libEGL.so.1", "glvnd/libGLdispatch.so.0"):  # of NVIDIA's driver
        assert os.path.exists(os.path.join(package, "lib", library)), f"the wheel lacks {library}"
    assert sorted(os.listdir(os.path.join(package, "bin"))) == WHEEL_PROGRAMS, os.listdir(os.path.join(package, "bin"))
    [entry_points] = glob.glob(os.path.join(folder, "*.dist-info", "entry_points.txt"))
    commands = re.findall(r"^([\w-]+) = fire3dv\.__main__:main$", open(entry_points, encoding="utf-8").read(), re.MULTILINE)
    assert sorted(commands) == WHEEL_PROGRAMS, commands
    [licence] = glob.glob(os.path.join(folder, "*.dist-info", "**", "LICENSE"), recursive=True)
    for part in ("OpenSSL", "libsodium", "Apache License"):
        assert part in open(licence, encoding="utf-8").read(), f"{part} is not in the wheel's LICENSE"
    assert {"libglfw3", "libvulkan1", "libopenexr-3-1-30"} & set(os.listdir(os.path.join(package, "licences"))), "licences"
    for program in (os.path.join(package, "bin", name) for name in WHEEL_PROGRAMS):  # pip marks them as executable
        os.chmod(program, 0o755)
    said = run(sys.executable, "-m", "fire3dv", "--version", cwd=work, PYTHONPATH=folder)
    assert f"fire3dv {version} " in said, said
    inside = os.path.join(package, "libfire3dv-client.so.0")
    said = run(sys.executable, "-W", "ignore", "-c", USE, "arm.glb", cwd=work, PYTHONPATH=folder)
    assert said.split() == [version, version, inside, f"{package}/__init__.py", f"{package}/bin/fire3dv", "(24,", "32,", "4)",
                            "True"], said
    said = run(sys.executable, "-m", "fire3dv", "demo", "--out", "demo", "--size", "64x36", cwd=work, PYTHONPATH=folder)
    refused = subprocess.run([sys.executable, "-m", "fire3dv", "demo", "--seconds", "0"], text=True, capture_output=True, check=False,
                             env={**CLEAN, "PYTHONPATH": folder})
    assert refused.returncode == 2 and "1 to 9999" in refused.stderr, refused
    assert "16 images of the moving arm" in said and len(glob.glob(os.path.join(work, "demo", "frame_*.png"))) == 16, said


def check_completions(root):
    def complete(program, *words):
        file = os.path.join(root, "usr/share/bash-completion/completions", program)
        return run("bash", "-c", 'compopt() { :; }; . "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); '
                   f'_{program.replace("-", "_")}; printf "%s\\n" "${{COMPREPLY[@]}}"', "bash", file, program, *words).split()
    assert complete("fire3dv", "scene.glb", "--head") == ["--headless"]
    assert complete("fire3dv", "--fxaa", "") == ["on", "off"]
    assert complete("fire3dv", "--raster", "f") == ["forward"]
    assert complete("fire3dv", "--listen", "t") == ["tcp://", "tls://"]
    assert "render" in complete("fire3dv", "rend")
    assert complete("fire3dv", "render", "run.mcap", "--cod") == ["--codec"]
    assert complete("fire3dv-record", "--compression", "z") == ["zstd"]


def has(tool):
    if not shutil.which(tool):
        print(f"packages: {tool} is not installed: its check is skipped")
    return shutil.which(tool)


def check_desktop(root, work):
    """Desktop entries open types that are known; file types, AppStream metadata and entries are valid."""
    share, entries = os.path.join(root, "usr/share"), glob.glob(os.path.join(root, "usr/share/applications/*.desktop"))
    types = {kind for entry in entries for line in open(entry, encoding="utf-8") if line.startswith("MimeType=")
             for kind in line[len("MimeType="):].strip().strip(";").split(";")}
    own = os.path.join(share, "mime/packages/fire3dv.xml")
    namespace = "{http://www.freedesktop.org/standards/shared-mime-info}"
    defined = [kind.get("type") for kind in xml.etree.ElementTree.parse(own).iter(namespace + "mime-type")]
    unclaimed = {"application/x-sdformat+xml"} - types  # without libsdformat
    assert set(defined) - unclaimed <= types, f"no desktop entry opens {sorted(set(defined) - types)}"
    common = "/usr/share/mime/packages/freedesktop.org.xml"
    if os.path.exists(common):
        known = {kind.get("type") for kind in xml.etree.ElementTree.parse(common).iter(namespace + "mime-type")}
        assert types <= known | set(defined), f"file types without a definition: {sorted(types - known - set(defined))}"
    metadata = os.path.join(share, "metainfo/org.fire3dv.fire3dv.metainfo.xml")
    provided = {kind.text for kind in xml.etree.ElementTree.parse(metadata).iter("mediatype")}
    assert provided == types - {"application/mcap"}, f"AppStream has {sorted(provided)}, the entries have {sorted(types)}"
    if has("desktop-file-validate"):
        run("desktop-file-validate", "--no-hints", *entries)
    if has("appstreamcli"):
        run("appstreamcli", "validate", "--no-net", metadata)
    if has("update-mime-database"):
        folder = os.path.join(work, "mime")
        shutil.copytree(os.path.join(share, "mime"), folder)
        said = run("update-mime-database", "-V", folder)
        globs = open(os.path.join(folder, "globs2"), encoding="utf-8").read().splitlines()
        assert {"50:application/mcap:*.mcap", "40:application/x-sdformat+xml:*.sdf"} <= set(globs), globs
        assert "rror" not in said and "arning" not in said, said


def check_service(root, work):
    """The unit is valid, confined, and leaves devices and shared memory to the renderer."""
    unit = open(os.path.join(root, "usr/lib/systemd/user/fire3dv@.service"), encoding="utf-8").read()
    settings = dict(re.findall(r"^(\w+)=(.*)$", unit, re.MULTILINE))
    assert settings["ExecStart"].split()[0] == "/usr/bin/fire3dv", settings["ExecStart"]
    for name in ("PrivateDevices", "ProtectClock", "PrivateIPC", "PrivateNetwork", "MemoryDenyWriteExecute", "ProcSubset"):
        assert name not in settings, f"{name} takes devices, shared memory, links or the driver's files away"
    if has("systemd-analyze"):
        path, environment = os.path.join(work, "fire3dv@lab.service"), {"XDG_RUNTIME_DIR": work, "HOME": work}
        with open(path, "w", encoding="utf-8") as file:
            file.write(unit.replace("/usr/bin/fire3dv", f"{root}/usr/bin/fire3dv"))
        said = subprocess.run(["systemd-analyze", "verify", "--user", "--man=no", path], text=True, capture_output=True, check=False,
                              env={**CLEAN, **environment})
        assert said.returncode == 0 and "fire3dv" not in said.stderr, said.stderr  # unknown settings are warnings only
        run("systemd-analyze", "--user", "security", "--offline=true", "--threshold=30", path, **environment)


with tempfile.TemporaryDirectory() as temporary:
    output, tree = os.path.join(temporary, "packages"), os.path.join(temporary, "root")
    packed = run(os.path.join(source, "tools/package.sh"), "--build", build, "--compression", "gzip", output)
    warnings = re.findall(r"^[EW]: .*$", packed, re.MULTILINE)  # of lintian; those that are right are in cmake/package/lintian
    assert not warnings, f"lintian: {warnings}"
    has("lintian")
    packages = {os.path.basename(path).split("_")[0]: path for path in glob.glob(output + "/*.deb")}
    names = {*PROGRAMS, "libfire3dv-client0", "libfire3dv-client-dev", "python3-fire3dv"}
    assert set(packages) == names, f"packages: {sorted(packages)}, expected {sorted(names)}"
    for each, package_file in packages.items():
        check_package(package_file, each)
        run("dpkg", "-x", package_file, tree)
    check_binaries(tree)
    check_renderer(tree, temporary)
    check_client(tree, temporary)
    check_python(tree, temporary, *glob.glob(output + "/*.whl"))
    check_completions(tree)
    check_desktop(tree, temporary)
    check_service(tree, temporary)
print("packages: passed")
