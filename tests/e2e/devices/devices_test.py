#!/usr/bin/env python3
"""End-to-end test of device and queue selection and of its log lines. The test driver offers one device (lavapipe) with
one queue.
"""
import csv
import json
import os
import re
import struct
import subprocess

from harness import HANG_S, main, vulkan_environment
from image_reader import check

WITHIN = r"gives: .*ray query.*up to \d+ samples"


def list_devices(test):
    result = subprocess.run([test.programs_at["fire3dv"], "--list-devices"], capture_output=True, text=True,
                            timeout=HANG_S, env=vulkan_environment(), check=False)
    check(result.returncode == 0 and result.stderr == "", f"{result}")
    lines = result.stdout.splitlines()
    check(len(lines) == 1 and re.match(r"0: llvmpipe .*\(software, .*Vulkan 1\.[3-9]", lines[0])
          and re.search(WITHIN, lines[0]) and re.search(r"; uuid:[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$", lines[0]),
          f"--list-devices says:\n{result.stdout}")


def chosen(*arguments):
    def run(test):
        renderer = test.renderer("--frames", "1", *arguments)
        renderer.expect_exit(0)
        line = renderer.wait_err(r"^fire3dv: info: device 0: llvmpipe .*\(software, .*\); " + WITHIN + "; lacks: .+")
        check("async compute queue" in line.group(0), f"it does not say what is lacking: {line.group(0)}")
        renderer.wait_err(r"^fire3dv: warning: device: llvmpipe .* is a software device: it draws on the CPU$")
        renderer.wait_err(r"^fire3dv: info: drawn from a visibility buffer, \d+ samples per pixel, shadows: shadow maps and ray query$")
        check(len(renderer.frames()) == 1, "no image")
    return run


def lit_scene(test):
    """Writes the tests' scene with a light, so that shadow rays are traced."""
    with open(test.scene, "rb") as file:
        data = file.read()
    length, = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20:20 + length])
    document["extensionsUsed"].append("KHR_lights_punctual")
    document["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}}
    document["scenes"][0]["nodes"].append(len(document["nodes"]))
    document["nodes"].append({"extensions": {"KHR_lights_punctual": {"light": 0}}})
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    path = test.path("lit.glb")
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(data) - 20 - length, len(text), b"JSON"))
        file.write(text + data[20 + length:])
    return path


def queues(test):
    scene, pictures = lit_scene(test), []
    for wish, said in (("auto", "on the main queue"), ("off", "on the main queue"),
                       ("on", r"in separate submissions on the main queue \(no async compute queue\)")):
        stats = test.path(f"{wish}.csv")
        renderer = test.renderer("--frames", "3", "--async-compute", wish, "--stats", stats, scene=scene)
        renderer.expect_exit(0)
        renderer.wait_err(rf"^fire3dv: info: acceleration structures are built {said}$")
        pictures.append([renderer.picture(frame).rows for frame in renderer.frames()])
        with open(stats, encoding="utf-8") as file:
            for row in csv.DictReader(file):
                check(float(row["tlas_ms"]) > 0, f"{wish}: nothing was built: {row}")
                check((float(row["async_queue_ms"]) > 0) == (wish == "on"), f"{wish}: {row}")
                check(float(row["async_queue_ms"]) <= float(row["gpu_ms"]), f"{wish}: outside the image's span: {row}")
    check(len(pictures[0]) == 3 and pictures[0] == pictures[1] == pictures[2], "images differ")
    untraced = test.renderer("--frames", "1", "--async-compute", "on", "--shadows", "map", scene=scene)
    untraced.expect_exit(0)
    check(not untraced.find_err("acceleration structures"), f"it builds what nobody traces:\n{untraced.stderr_text()}")


def uuid_of_the_device(test):
    result = subprocess.run([test.programs_at["fire3dv"], "--list-devices"], capture_output=True, text=True,
                            timeout=HANG_S, env=vulkan_environment(), check=True)
    return re.search(r"uuid:\S+", result.stdout).group(0)


def by_uuid(test):
    chosen("--device", uuid_of_the_device(test).upper().replace("-", ""))(test)


def forms(test):
    """Malformed and unmatched forms are errors that name the option; a form is never part of a name."""
    for device, words in (("cuda:llvmpipe", "--device cuda:llvmpipe: cuda: needs CUDA's number"),
                          ("uuid:llvmpipe", "32 hexadecimal digits"), ("pci:llvmpipe", "pci:0000:65:00.0"),
                          ("pci:0000:01:00.0", "there is no such device"), ("cuda:7", "--device cuda:7: CUDA")):
        renderer = test.renderer("--frames", "1", "--device", device)
        renderer.expect_exit(1)
        line = renderer.wait_err(r"^fire3dv: error: --device " + device + ": .*")
        check(words in line.group(0), f"{device}: {line.group(0)}")


def require_gpu(test):
    """Every program that draws refuses the software device, before it opens a scene."""
    refused = "error: --require-gpu: no GPU can draw here; llvmpipe "
    missing = os.path.join(test.folder, "missing.glb")
    for program, *arguments in (("fire3dv", missing, "--headless", "--frames", "1"),
                                ("fire3dv", test.scene, "--headless", "--devices", "0,0", "--listen", "shm://require_gpu"),
                                ("fire3dv", "--list-devices"),
                                ("fire3dv", "render", "missing.mcap", "--out", test.folder),
                                ("fire3dv", "dataset", missing, "--format", "coco", "--out", test.folder),
                                ("fire3dv-drake", "127.0.0.1:0")):
        result = subprocess.run([test.programs_at[program], *arguments, "--require-gpu"], capture_output=True, text=True,
                                timeout=HANG_S, env=vulkan_environment(), check=False)
        check(result.returncode == 3 and result.stdout == "" and refused in result.stderr, f"{arguments}: {result}")


CASES = {"list_devices": list_devices, "by_itself": chosen(), "by_name": chosen("--device", "llvmpipe"),
         "by_part_of_its_name": chosen("--device", "LLVMpip"), "by_index": chosen("--device", "0"),
         "by_uuid": by_uuid, "forms": forms, "require_gpu": require_gpu, "queues": queues}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "fire3dv-drake"])
