"""fire3dv doctor on broken set-ups: each is named by its check, with a line to type, and the exit status tells.

doctor_test.py FIRE3DV FAKE_DRIVER FAKE_LAYER FAKE_CUDA [CASE...]
"""
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile

FIRE3DV, FAKE_DRIVER, FAKE_LAYER, FAKE_CUDA, *ONLY = sys.argv[1:]
GOOD_DRIVERS = os.environ["VK_DRIVER_FILES"]
HANG_S = 300
LIMIT_S = "120"  # of each experiment; far above the usual time, but where a driver hangs on purpose


class Machine:
    """Environment of the doctor, and a folder of its own."""

    def __init__(self, folder):
        self.folder = folder
        self.home = os.path.join(folder, "home", "ada")
        os.makedirs(self.home)
        self.env = {"PATH": os.environ["PATH"], "HOME": self.home, "VK_DRIVER_FILES": GOOD_DRIVERS, "NODEVICE_SELECT": "1",
                    **{name: value for name, value in os.environ.items()
                       if name.startswith(("ASAN_", "UBSAN_", "TSAN_", "MESA_SHADER_CACHE"))}}

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def manifest(self, library, name="icd.json"):
        return self.write(name, json.dumps({"file_format_version": "1.0.0", "ICD": {"library_path": library, "api_version": "1.3.0"}}))

    def layer(self, name, library):
        """An implicit layer that NO_NAME switches off."""
        self.env["XDG_DATA_HOME"] = self.folder
        os.makedirs(os.path.join(self.folder, "vulkan/implicit_layer.d"), exist_ok=True)
        self.write(f"vulkan/implicit_layer.d/{name}.json", json.dumps({"file_format_version": "1.0.0", "layer": {
            "name": f"VK_LAYER_TEST_{name}", "type": "GLOBAL", "library_path": library, "api_version": "1.3.0", "implementation_version": "1",
            "description": name, "disable_environment": {f"NO_{name.upper()}": "1"}}}))

    def fake(self, way=None):
        """The only driver is the fake one, which breaks in this way."""
        self.env["VK_DRIVER_FILES"] = self.manifest(FAKE_DRIVER)
        if way:
            self.env["FIRE3DV_FAKE_DRIVER"] = way

    def fake_of_the_system(self):
        """The fake driver lies in a folder of the system, and no variable names drivers."""
        del self.env["VK_DRIVER_FILES"]
        os.makedirs(os.path.join(self.folder, "vulkan/icd.d"))
        self.manifest(FAKE_DRIVER, "vulkan/icd.d/gpu.json")
        self.env |= {"XDG_DATA_HOME": self.folder, "XDG_DATA_DIRS": "/nowhere", "XDG_CONFIG_DIRS": "/nowhere"}

    def run(self, *options, prefix=(), limit_s=LIMIT_S):
        return subprocess.run([*prefix, FIRE3DV, "doctor", "--time-limit", limit_s, *options], capture_output=True, text=True,
                              timeout=HANG_S, env=self.env, check=False)

    def findings(self, *options, status, **how):
        """Findings that are not ok, by their id."""
        done = self.run("--json", *options, **how)
        assert done.returncode == status, f"exit status {done.returncode}, not {status}:\n{done.stdout}{done.stderr}"
        report = json.loads(done.stdout)
        assert report["exit_status"] == status, report
        return {each["id"]: each for each in report["findings"] if each["level"] != "ok"}


def expect(findings, name, level, text, fix=""):
    assert name in findings, f"no finding {name} in {json.dumps(findings, indent=1)}"
    found = findings[name]
    assert found["level"] == level and re.search(text, found["text"]) and re.search(fix, found["fix"]), found


def good(machine):
    done = machine.run()
    assert done.returncode == 0, done.stdout
    assert re.search(r"^ok +read-back .* on device 0$", done.stdout, re.M), done.stdout
    assert re.search(r"^ok +ray-tracing +a ray hit", done.stdout, re.M), done.stdout
    assert re.search(r"^0 +- +.* llvmpipe", done.stdout, re.M), done.stdout
    assert not re.search("^(warning|error) +(?!shared-memory|device-nodes)", done.stdout, re.M), done.stdout


def no_loader(machine):
    machine.write("libvulkan.so.1", "no library")
    machine.env["LD_LIBRARY_PATH"] = machine.folder
    found = machine.findings(status=1)
    expect(found, "loader", "error", "no usable Vulkan loader: .*libvulkan.so.1: .*; LD_LIBRARY_PATH leads to ", "^unset LD_LIBRARY_PATH$")
    assert [name for name, each in found.items() if each["level"] == "error"] == ["loader"], found
    done = subprocess.run([FIRE3DV, "--list-devices"], capture_output=True, text=True, timeout=HANG_S, env=machine.env, check=False)
    assert done.returncode == 1 and "there is no usable Vulkan loader (" in done.stderr, done


def loader_is_a_pipe(machine):
    os.mkfifo(os.path.join(machine.folder, "libvulkan.so.1"))
    machine.env["LD_LIBRARY_PATH"] = machine.folder
    expect(machine.findings(status=1), "loader", "error", "libvulkan.so.1 is no file; LD_LIBRARY_PATH leads to ", "^unset LD_LIBRARY_PATH$")
    for options, status in ((["--help"], 0), (["--list-devices"], 1)):
        done = subprocess.run([FIRE3DV, *options], capture_output=True, text=True, timeout=HANG_S, env=machine.env, check=False)
        assert done.returncode == status, done


def driver_variable(machine):
    machine.env["VK_DRIVER_FILES"] = "/nowhere.json"
    found = machine.findings(status=1)
    expect(found, "driver-variables", "error", 'VK_DRIVER_FILES names "/nowhere.json": it does not exist', "^unset VK_DRIVER_FILES")
    expect(found, "devices", "error", "no driver lists|listing", "unset")


def empty_driver_folder(machine):
    os.makedirs(os.path.join(machine.folder, "none"))
    machine.env["VK_DRIVER_FILES"] = os.path.join(machine.folder, "none")
    expect(machine.findings(status=1), "driver-variables", "error", "names no driver manifest")


def broken_manifest(machine):
    machine.env["VK_DRIVER_FILES"] = machine.write("icd.json", "{")
    expect(machine.findings(status=1), "driver-variables", "error", "it is no JSON")


def missing_library(machine):
    machine.env["VK_DRIVER_FILES"] = machine.manifest("libno-such-driver.so.1")
    expect(machine.findings(status=1), "driver-manifests", "error", "libno-such-driver.so.1: cannot open shared object file",
           "ldconfig -p")


def no_library_at_all(machine):
    machine.env["VK_DRIVER_FILES"] = machine.manifest(machine.write("text.so", "no library"))
    expect(machine.findings(status=1), "driver-manifests", "error", "fails: .*(ELF|too short)")


def fake_works(machine):
    machine.fake()
    found = machine.findings(status=0)
    assert "read-back" not in found and "ray-tracing" not in found, found


def gpu_before_added_software(machine):
    """The wheel adds its software driver to those of the system: a GPU is taken all the same."""
    machine.fake_of_the_system()
    machine.env["VK_ADD_DRIVER_FILES"] = GOOD_DRIVERS
    report = json.loads(machine.run("--json").stdout)
    types = {each["type"]: each["name"] for each in report["devices"]}
    assert types["discrete GPU"] == "fake GPU" and "llvmpipe" in types["software"], report["devices"]
    assert any(re.fullmatch(r"fire3dv takes device \d \(fake GPU\) by itself", each["text"]) for each in report["findings"]), report["findings"]


def crash_on_load(machine):
    machine.fake("crash_on_load")
    expect(machine.findings(status=1), "driver-manifests", "error", r"icd.json cannot be loaded: .* crashes \(SIGKILL\)")


def hang_in_listing(machine):
    machine.fake("hang_in_listing")
    machine.env["VK_DRIVER_FILES"] += ":" + GOOD_DRIVERS
    found = machine.findings(status=1, limit_s="5")
    expect(found, "devices", "error", "driver of .*/icd.json hangs .for more than 5 s. when it lists", "^export VK_DRIVER_FILES=" + re.escape(GOOD_DRIVERS))


def crash_in_listing(machine):
    machine.fake("crash_in_listing")
    expect(machine.findings(status=1), "devices", "error", r"icd.json crashes \(SIGKILL\) when it lists")


def hang_in_read_back(machine):
    machine.fake("hang_in_wait")
    expect(machine.findings(status=1, limit_s="5"), "read-back", "error", r"device 0 \(fake GPU\) is listed, but opening it, .* hangs")


def wrong_pixels(machine):
    machine.fake("wrong_pixels")
    machine.env["VK_DRIVER_FILES"] += ":" + GOOD_DRIVERS
    expect(machine.findings(status=1), "read-back", "error", "pixel 0 has a wrong colour", r"^fire3dv --device \d FILE$")


def crash_in_rays(machine):
    machine.fake("crash_in_rays")
    expect(machine.findings(status=1), "ray-tracing", "error", r"claims ray tracing, but tracing one ray crashes \(SIGKILL\)",
           "^fire3dv --shadows map FILE$")


def old_mesa(machine):
    machine.fake("old_mesa")
    expect(machine.findings(status=1), "old-mesa", "error", "Mesa 22.3 is too old.*runtimeDescriptorArray", "mesa-vulkan-drivers")


def no_home(machine):
    machine.fake()
    del machine.env["HOME"]
    found = machine.findings(status=0)
    expect(found, "home", "note", "HOME is not set")
    expect(found, "cache", "warning", "nothing names a folder for caches", "XDG_CACHE_HOME")


def cache_is_a_file(machine):
    machine.fake()
    machine.env["XDG_CACHE_HOME"] = machine.write("file", "")
    expect(machine.findings(status=0), "cache", "warning", "cannot be written")


def display_without_server(machine):
    machine.fake()
    machine.env["DISPLAY"] = ":4711"
    expect(machine.findings(status=0), "display", "warning", "display :4711 cannot be reached", "--headless")
    machine.env["DISPLAY"] = "garbage"
    expect(machine.findings(status=0), "display", "warning", "garbage cannot be reached.*not of the form")
    machine.env["DISPLAY"] = "localhost:59000"
    expect(machine.findings(status=0), "display", "warning", "localhost port 65000: ")


def few_files(machine):
    machine.fake()
    found = machine.findings(status=0, prefix=("sh", "-c", 'ulimit -n 64; ulimit -l 0; exec "$@"', "sh"))
    expect(found, "open-files", "warning", "may open only 64 files", "ulimit -n")
    expect(found, "locked-memory", "note", "only 0 KiB")


def no_experiments(machine):
    machine.fake()
    found = machine.findings(status=1, prefix=("sh", "-c", 'ulimit -n 4; exec "$@"', "sh"))
    expect(found, "experiments", "error", "cannot be tried: .*Too many open files", "ulimit -n")
    assert [name for name, each in found.items() if each["level"] == "error"] == ["experiments"], found


def closed_files(machine):
    machine.fake()
    machine.findings(status=0, prefix=("sh", "-c", 'exec "$@" <&- 2>&-', "sh"))


def children_are_ignored(machine):
    machine.fake()
    machine.findings(status=0, prefix=("sh", "-c", 'trap "" CHLD; exec "$@"', "sh"))


def driver_without_instance(machine):
    machine.fake("no_instance")
    expect(machine.findings(status=1), "driver-manifests", "error", "fails: it has no vkCreateInstance$", "ldd")


def port_in_use(machine):
    machine.fake()
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        found = machine.findings("--listen", f"tcp://127.0.0.1:{port}", status=1)
        expect(found, "ports", "error", f"--listen tcp://127.0.0.1:{port} cannot be opened: (?!tcp:).*in use")
    found = machine.findings("--serve", "127.0.0.1:0", "--listen", "udp://127.0.0.1:0", "--listen", "shm://demo", status=0)
    assert "ports" not in found, found


def foreign_layer(machine):
    machine.fake()
    machine.layer("x", "x.so")
    expect(machine.findings(status=0), "implicit-layers", "note", "VK_LAYER_TEST_x", "^export .*NO_X=1")


def layer_hangs(machine):
    machine.fake()
    machine.layer("good", "no_such_layer.so")
    machine.layer("bad", FAKE_LAYER)
    found = machine.findings(status=1, limit_s="5")
    expect(found, "implicit-layers", "error", "hangs .* by the implicit layer VK_LAYER_TEST_bad of ", "^export NO_BAD=1$")
    assert [name for name, each in found.items() if each["level"] == "error"] == ["implicit-layers"], found
    machine.env["VK_LOADER_LAYERS_DISABLE"] = "*test_b*"
    expect(machine.findings(status=0), "implicit-layers", "note", "VK_LAYER_TEST_good$")


def cuda_without_a_device(machine):
    """No variable replaces the drivers here: it would switch the check off."""
    machine.fake_of_the_system()
    os.symlink(FAKE_CUDA, os.path.join(machine.folder, "libcuda.so.1"))
    machine.env["LD_LIBRARY_PATH"] = machine.folder
    for devices, is_found in (("0", False), ("1", True)):
        machine.env["FIRE3DV_FAKE_CUDA_DEVICES"] = devices
        report = json.loads(machine.run("--json").stdout)
        assert len(report["cuda_devices"]) == int(devices), report["cuda_devices"]
        found = {each["id"]: each for each in report["findings"] if each["level"] != "ok"}
        if is_found:
            expect(found, "nvidia-without-vulkan", "error", "CUDA works")
        else:
            assert "nvidia-without-vulkan" not in found or os.path.exists("/dev/nvidiactl"), found


def hidden_driver(machine):
    machine.fake()
    machine.env["VK_LOADER_DRIVERS_DISABLE"] = "*ICD*"
    found = machine.findings(status=1)
    expect(found, "driver-variables", "error", "VK_LOADER_DRIVERS_DISABLE .* hides all drivers: .*icd.json", "^unset VK_LOADER_DRIVERS_DISABLE$")


def library_is_a_pipe(machine):
    pipe = os.path.join(machine.folder, "pipe.so")
    os.mkfifo(pipe)
    machine.env["VK_DRIVER_FILES"] = machine.manifest(pipe) + ":" + GOOD_DRIVERS
    found = machine.findings(status=1, limit_s="5")
    expect(found, "driver-manifests", "warning", "pipe.so hangs", "^ls -lL ")
    expect(found, "devices", "error", "icd.json hangs .* when it is loaded", "^export VK_DRIVER_FILES=" + re.escape(GOOD_DRIVERS))


def deep_or_empty_manifest(machine):
    machine.env["VK_DRIVER_FILES"] = machine.write("deep.json", '{"ICD":' + "[" * 100000 + "]" * 100000 + "}")
    expect(machine.findings(status=1), "driver-variables", "error", "nested deeper than 32 levels")
    machine.env["VK_DRIVER_FILES"] = machine.manifest("")
    expect(machine.findings(status=1), "driver-variables", "error", "library_path is empty")


def wrong_mask(machine):
    machine.fake()
    machine.env["FIRE3DV_DEVICE_MASK"] = "samples=3"
    found = machine.findings(status=1)
    expect(found, "devices", "error", "FIRE3DV_DEVICE_MASK: .samples=3. is no power of two", "^unset FIRE3DV_DEVICE_MASK$")


def report_for_an_issue(machine):
    machine.fake("hang_in_wait")
    machine.env |= {"USER": "ada", "HOSTNAME": "Box7", "NVIDIA_API_KEY": "nvapi-secret", "DISPLAY": "box7.example.org:4711"}
    path = os.path.join(machine.folder, "report.md")
    done = machine.run("--report", path, limit_s="5")
    assert done.returncode == 1, done
    with open(path, encoding="utf-8") as file:
        text = file.read()
    assert "error    read-back" in text and "VK_DRIVER_FILES=" in text, text
    names = [re.escape(machine.home), "ada", *([re.escape(socket.gethostname())] if socket.gethostname() != "localhost" else [])]
    for name in names:
        assert not re.search(rf"(?<![\w.-]){name}(?![\w.-])", text), f"{name} is in the report:\n{text}"
    assert not re.search("nvapi|API_KEY|box7", text, re.I), text


def report_to_links_and_pipes(machine):
    machine.fake("crash_on_load")
    target, link, pipe = (os.path.join(machine.folder, name) for name in ("target.md", "link.md", "pipe"))
    os.symlink("target.md", link)
    assert machine.run("--report", link).returncode == 1
    with open(target, encoding="utf-8") as file:
        assert os.path.islink(link) and file.read().startswith("Output of `fire3dv doctor`")
    os.mkfifo(pipe)
    with open(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK), encoding="utf-8") as reader:
        assert machine.run("--report", pipe).returncode == 1
        assert os.path.exists(pipe) and "driver-manifests" in reader.read()
    with open(target, "w+", encoding="utf-8") as output:  # standard output is a file: it gets both
        subprocess.run([FIRE3DV, "doctor", "--report", "/dev/stdout"], stdout=output, stderr=subprocess.DEVNULL, env=machine.env, check=False)
        output.seek(0)
        assert re.search("^fire3dv .*^Output of `fire3dv doctor`.*```$", output.read(), re.M | re.S)
    assert os.path.islink("/dev/stdout")
    with open(target, "w+", encoding="utf-8") as log:  # a file behind another descriptor is continued
        log.write("earlier\n")
        log.flush()
        subprocess.run([FIRE3DV, "doctor", "--report", "/dev/stderr"], stdout=subprocess.DEVNULL, stderr=log, env=machine.env, check=False)
        log.seek(0)
        assert re.search("^earlier\nOutput of `fire3dv doctor`", log.read()), "the file was replaced"


def usage(machine):
    for options in (["--bench", "--json"], ["--time-limit", "x"], ["--tmie-limit", "3"], ["file"]):
        done = subprocess.run([FIRE3DV, "doctor", *options], capture_output=True, text=True, timeout=HANG_S, env=machine.env, check=False)
        assert done.returncode == 2 and done.stderr.startswith("fire3dv doctor: error: ") and not done.stdout, done


def own_mounts(machine, script):
    """Findings in a mount namespace of its own; None where this user may not have one."""
    enter = ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]
    if not shutil.which("unshare") or subprocess.run([*enter, "true"], capture_output=True, check=False).returncode:
        print("skipped: no mount namespaces for this user")
        return None
    return machine.findings(status=0, prefix=(*enter, "sh", "-c", script + ' && exec "$@"', "sh"))


def small_shared_memory(machine):
    machine.fake()
    found = own_mounts(machine, "mount -t tmpfs -o size=64m tmpfs /dev/shm")
    if found is not None:
        expect(found, "shared-memory", "warning", "only 64 MiB", "size=1g")


def read_only_shared_memory(machine):
    machine.fake()
    found = own_mounts(machine, "mount -t tmpfs -o ro tmpfs /dev/shm")
    if found is not None:
        expect(found, "shared-memory", "warning", "mounted read-only", "mount|shm-size")


def read_only_home(machine):
    machine.fake()
    found = own_mounts(machine, f"mount -t tmpfs -o ro tmpfs {machine.folder}/home && mkdir -p /dev/shm")
    if found is not None:
        expect(found, "cache", "warning", "cannot be written (.*Read-only file system)", "XDG_CACHE_HOME")


CASES = [good, no_loader, loader_is_a_pipe, driver_variable, empty_driver_folder, broken_manifest, missing_library, no_library_at_all, fake_works, gpu_before_added_software, crash_on_load,
         hang_in_listing, crash_in_listing, hang_in_read_back, wrong_pixels, crash_in_rays, old_mesa, no_home, cache_is_a_file,
         display_without_server, few_files, no_experiments, closed_files, children_are_ignored, driver_without_instance, port_in_use, foreign_layer, layer_hangs, cuda_without_a_device, hidden_driver, library_is_a_pipe, deep_or_empty_manifest, wrong_mask, report_for_an_issue, report_to_links_and_pipes, usage, small_shared_memory, read_only_shared_memory, read_only_home]

for case in CASES:
    if ONLY and case.__name__ not in ONLY:
        continue
    with tempfile.TemporaryDirectory(prefix="fire3dv-doctor-") as folder_of_case:
        print(case.__name__, flush=True)
        case(Machine(folder_of_case))
