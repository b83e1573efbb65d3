"""Virtual hosts on this machine: network namespaces joined by veth pairs, which end with the test.

The namespaces have no names. Each lives as long as a process that waits for the end of the test, so nothing is left
behind in any case. A host may have its own clock (time namespace) and boot id, like another machine.
"""
import os
import subprocess

from harness import wait_until
from image_reader import check

SKIPPED = 77  # CTest's SKIP_RETURN_CODE


def why_not():
    """Returns the reason why virtual hosts are unavailable, or None."""
    try:
        done = subprocess.run(["unshare", "--net", "ip", "link", "set", "lo", "up"], capture_output=True, text=True, check=False)
    except FileNotFoundError as missing:
        return f"{missing.filename} is not installed: run tools/setup.sh"
    return None if done.returncode == 0 else f"network namespaces are not permitted here: {done.stderr.strip()}"


def has_private_mounts():
    """False in a chroot, for example."""
    return subprocess.run(["unshare", "--mount", "true"], capture_output=True, check=False).returncode == 0


def has_own_clocks():
    """True if a host may have its own clock, and a boot id that is mounted over the machine's."""
    return has_private_mounts() and subprocess.run(["unshare", "--time", "--fork", "true"], capture_output=True,
                                                   check=False).returncode == 0


class Host:
    def __init__(self, test, name, clock_ahead_s=0):
        """clock_ahead_s: offset of its monotonic clock to the machine's; the host then has another boot id."""
        self.name, self._ends = name, 0
        own_time = ["--mount", "--time", "--monotonic", str(clock_ahead_s)] if clock_ahead_s else []
        # The script prints its own process id: with a time namespace it is a child of unshare.
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
    """Host of a simulator, host of a renderer, and a relay host between them that forwards only through fire3dv-impair."""
    RELAY, VIEW = "10.71.0.2", "10.72.0.2"  # the relay's address for the simulator, and the renderer's for the relay

    def __init__(self, test):
        self.clocks_differ = has_own_clocks()
        self.simulator = Host(test, "simulator", clock_ahead_s=54321 if self.clocks_differ else 0)
        self.between = Host(test, "between")
        self.view = Host(test, "view")
        cable(self.simulator, self.between, "10.71.0")
        cable(self.between, self.view, "10.72.0")
