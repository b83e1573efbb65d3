"""Hosts of their own on this machine: network namespaces that cables (veth) join, and that end with the test.

They have no names: each lives as long as a process that waits for the end of the test, so that nothing is left behind
however the test ends. A host may have a clock and a boot id of its own, as another machine has.
"""
import os
import subprocess

from harness import wait_until
from pictures import check

SKIPPED = 77  # what CTest is told


def why_not():
    """Why there can be no hosts here, or None."""
    try:
        done = subprocess.run(["unshare", "--net", "ip", "link", "set", "lo", "up"], capture_output=True, text=True, check=False)
    except FileNotFoundError as missing:
        return f"{missing.filename} is not installed: run tools/setup.sh"
    return None if done.returncode == 0 else f"network namespaces are not permitted here: {done.stderr.strip()}"


def has_private_mounts():
    """Not in a chroot, for one."""
    return subprocess.run(["unshare", "--mount", "true"], capture_output=True, check=False).returncode == 0


def has_own_clocks():
    """Whether a host may have a clock, and a boot id that lies over the machine's."""
    return has_private_mounts() and subprocess.run(["unshare", "--time", "--fork", "true"], capture_output=True,
                                                   check=False).returncode == 0


class Host:
    def __init__(self, test, name, clock_ahead_s=0):
        """clock_ahead_s: how far its monotonic clock is ahead of the machine's; it has another boot id, then."""
        self.name, self._ends = name, 0
        own_time = ["--mount", "--time", "--monotonic", str(clock_ahead_s)] if clock_ahead_s else []
        # The shell's own id is told, since with a time namespace it is a child of unshare.
        script = "ip link set lo up && echo $$ && exec cat"
        self.holder = subprocess.Popen(["unshare", "--net", *own_time, "--fork", "--kill-child", "sh", "-c", script],
                                       stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        test.hosts.append(self)
        line = self.holder.stdout.readline().strip()
        check(line.isdigit(), f"the host {name} does not start")
        self.pid = int(line)
        self.enter = ["nsenter", "--target", str(self.pid), "--net", *(["--mount", "--time"] if clock_ahead_s else [])]
        if clock_ahead_s:
            boot_id = test.path(f"boot_id_{name}")
            with open(boot_id, "w", encoding="ascii") as file:
                file.write("12345678-9abc-4def-8123-456789abcdef\n")
            self.run("mount", "--bind", boot_id, "/proc/sys/kernel/random/boot_id")

    def run(self, *command):
        done = subprocess.run([*self.enter, *command], capture_output=True, text=True, check=False)
        check(done.returncode == 0, f"{self.name}: {' '.join(command)}: {done.stderr}")
        return done.stdout

    def end(self):
        self.holder.stdin.close()
        self.holder.wait()


def cable(a, b, subnet):
    """Joins two hosts, as subnet.1 and subnet.2."""
    ends = []
    for host in (a, b):
        ends.append(f"cable{host._ends}")
        host._ends += 1
    done = subprocess.run(["ip", "link", "add", ends[0], "netns", str(a.pid), "type", "veth", "peer", "name", ends[1],
                           "netns", str(b.pid)], capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"no cable: {done.stderr}")
    for i, host in enumerate((a, b)):
        host.run("ip", "address", "add", f"{subnet}.{i + 1}/24", "dev", ends[i])
        host.run("ip", "link", "set", ends[i], "up")
    for i, host in enumerate((a, b)):
        wait_until(f"{ends[i]} of {host.name} to be up",
                   lambda h=host, e=ends[i]: "state UP" in h.run("ip", "link", "show", e))


class TwoHosts:
    """A simulator's host and a renderer's, and between them one through which nothing passes but what a relay takes on."""
    RELAY, VIEW = "10.71.0.2", "10.72.0.2"  # where the simulator finds the relay, and the relay the renderer

    def __init__(self, test):
        self.clocks_differ = has_own_clocks()
        self.simulator = Host(test, "simulator", clock_ahead_s=54321 if self.clocks_differ else 0)
        self.between = Host(test, "between")
        self.view = Host(test, "view")
        cable(self.simulator, self.between, "10.71.0")
        cable(self.between, self.view, "10.72.0")
