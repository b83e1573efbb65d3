#!/usr/bin/env python3
"""Which device is taken, and that it says so. The tests' driver gives one device, lavapipe."""
import re
import subprocess

from harness import HANG_S, main, vulkan_environment
from pictures import check

WITHIN = r"gives: .*ray query.*up to \d+ samples"


def list_devices(test):
    result = subprocess.run([test.programs_at["fire3dv"], "--list-devices"], capture_output=True, text=True,
                            timeout=HANG_S, env=vulkan_environment(), check=False)
    check(result.returncode == 0 and result.stderr == "", f"{result}")
    lines = result.stdout.splitlines()
    check(len(lines) == 1 and re.match(r"0: llvmpipe .*\(software, .*Vulkan 1\.[3-9]", lines[0])
          and re.search(WITHIN, lines[0]), f"--list-devices says:\n{result.stdout}")


def chosen(*arguments):
    def run(test):
        renderer = test.renderer("--frames", "1", *arguments)
        renderer.expect_exit(0)
        line = renderer.wait_err(r"^fire3dv: device 0: llvmpipe .*\(software, .*\); " + WITHIN + "; lacks: .+")
        check("async compute queue" in line.group(0), f"it does not say what is lacking: {line.group(0)}")
        renderer.wait_err(r"^fire3dv: device: llvmpipe .* is a software device: it draws on the CPU$")
        renderer.wait_err(r"^fire3dv: drawn from a visibility buffer, \d+ samples a pixel, shadows by shadow maps and ray query$")
        check(len(renderer.frames()) == 1, "no image")
    return run


CASES = {"list_devices": list_devices, "by_itself": chosen(), "by_name": chosen("--device", "llvmpipe"),
         "by_part_of_its_name": chosen("--device", "LLVMpip"), "by_index": chosen("--device", "0")}

if __name__ == "__main__":
    main(CASES, ["fire3dv"])
