#!/usr/bin/env python3
"""Runs the commands of examples/remote/README.md as they stand there, and looks at what they leave.

  remote_example_test.py README BIN_DIR
"""
import json
import os
import re
import subprocess
import sys
import tempfile

import hosts
from harness import vulkan_environment
from image_reader import Failure, check

HANG_S = 900


def commands_of(readme):
    with open(readme, encoding="utf-8") as file:
        blocks = re.findall(r"^```sh\n(.*?)^```$", file.read(), re.MULTILINE | re.DOTALL)
    check(len(blocks) >= 4, f"{readme} has {len(blocks)} blocks of commands")
    return "\n".join(blocks)


def images_of(folder):
    with open(os.path.join(folder, "frames.jsonl"), encoding="utf-8") as log:
        frames = [json.loads(line) for line in log]
    return [f for f in frames if f["streams"] and os.path.getsize(os.path.join(folder, f["file"])) > 1000]


def main():
    check(len(sys.argv) == 3, __doc__)
    readme, bin_dir = map(os.path.abspath, sys.argv[1:])
    with tempfile.TemporaryDirectory(prefix="fire3dv-remote-") as folder:
        os.makedirs(os.path.join(folder, "build", "release"))
        os.symlink(bin_dir, os.path.join(folder, "build", "release", "bin"))
        os.makedirs(os.path.join(folder, "build", "lab"))
        os.symlink(bin_dir, os.path.join(folder, "build", "lab", "bin"))
        # Namespace names are files in /run: a private /run keeps them separate and removes them with the
        # test.
        script = "mount -t tmpfs tmpfs /run\nset -eu\n" + commands_of(readme)
        done = subprocess.run(["unshare", "--net", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc", "bash", "-c", script],
                              cwd=folder, env={**vulkan_environment(), "XDG_CACHE_HOME": os.path.join(folder, "cache")},
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=HANG_S, check=False)
        check(done.returncode == 0, f"the README's commands end with {done.returncode}:\n{done.stdout}")
        for link in ("udp", "tls"):
            images = images_of(os.path.join(folder, "remote", link))
            last = max((f["streams"][0]["sequence"] for f in images), default=0)
            check(last >= 21, f"what the simulator waited for was not drawn over {link}: {last}\n{done.stdout}")
        check(re.search(r"^interpolated +[0-9.]+ mm RMS", done.stdout, re.MULTILINE), f"no score:\n{done.stdout}")
        print(done.stdout)


if __name__ == "__main__":
    reason = hosts.why_not() or (None if hosts.has_private_mounts() else "its namespaces' names need mounts of its own")
    if reason:
        print(f"skipped: {reason}")
        sys.exit(hosts.SKIPPED)
    try:
        main()
    except Failure as failure:
        sys.exit(f"remote_example_test: {failure}")
