#!/usr/bin/env python3
"""Each attack of greedy_attacks.h by one peer, beside an honest peer that waits for the image of each of its frames. The
honest peer keeps LEAST_RATIO of its undisturbed rate and gets the same images as without the attack; the renderer's memory
stays bounded; the renderer goes on, and ends on SIGTERM.

greedy_peers_test.py FIRE3DV GREEDY_PEER [--report | --strict] [ATTACK...]; --report prints the figures and fails for nothing.

Rates are compared within one run, per second that other processes leave to the renderer, and the best of TRIES counts. Two
loaded cores vary by a third from run to run, so the test fails below NOISY_RATIO; --strict holds LEAST_RATIO itself."""
import os
import re
import signal
import subprocess
import sys
import time

from greedy_scene import write_asset, write_scene
from harness import HANG_S, Program, Test, vulkan_environment, wait_until
from image_reader import Failure, check

LEAST_RATIO = 0.5
NOISY_RATIO = 0.3
TRIES = 4
BEFORE_S, DURING_S, AFTER_S = 0.5, 1.5, 0.3
MOST_DURING_S = 12  # where the attack takes longer to be sent
STOP_S = 20  # from SIGTERM to the end
MOST_MIB = 600  # above the idle renderer, unless an attack has another bound
REPORT_WAIT_S = 60
NODES = ("body", "root/left/twin")


class Attack:
    def __init__(self, asset=None, honest=(), most_mib=MOST_MIB, newcomer=False, stop_under_attack=False,
                 during_s=DURING_S):
        self.asset = asset  # images and their side
        self.honest, self.most_mib, self.newcomer = honest, most_mib, newcomer
        self.stop_under_attack, self.during_s = stop_under_attack, during_s


ATTACKS = {
    "huge_images": Attack(asset=(2, 8192)),
    # The honest peer's frames wait for nodes that it adds; each addition replaces the scene, beside the large image of
    # the other peer.
    "busy_builds": Attack(asset=(1, 4096), honest=("edits",)),
    "lights_1000": Attack(),
    "lights_5000": Attack(),
    "orphan_vertices": Attack(),
    "nested_names": Attack(during_s=8),  # it takes that long to be built
    "many_names": Attack(),
    "empty_nodes": Attack(),
    "colliding_names": Attack(),
    "hidden_root": Attack(),
    "removed_root": Attack(),
    "duplicate_path": Attack(),
    "slow_readers": Attack(),
    "large_requests": Attack(stop_under_attack=True),
    "many_requests": Attack(during_s=4),  # its first image compiles pipelines
    "reconnects": Attack(),
    "empty_states": Attack(),
    "half_frames": Attack(most_mib=200),
    "silent_connections": Attack(newcomer=True),
    "squatter": Attack(honest=("describes",)),
    "epoch_takeover": Attack(),
}


def memory_kib(pid, field):
    with open(f"/proc/{pid}/status", encoding="ascii") as file:
        return int(re.search(rf"^{field}:\s+(\d+) kB", file.read(), re.M).group(1))


def process_s(pid):
    """Processor time of a process so far."""
    with open(f"/proc/{pid}/stat", encoding="ascii", errors="replace") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def machine_s():
    """Processor time of all processes so far, and the number of processors."""
    with open("/proc/stat", encoding="ascii") as file:
        lines = file.read().splitlines()
    user, nice, system, _, _, irq, softirq, steal = (int(n) for n in lines[0].split()[1:9])
    processors = sum(1 for line in lines if re.match(r"cpu\d", line))
    return (user + nice + system + irq + softirq + steal) / os.sysconf("SC_CLK_TCK"), processors


class Honest(Program):
    def __init__(self, test, uri, *options):
        super().__init__(test, "the honest peer", [test.programs_at["greedy_peer"], "honest", uri, *options])
        self.answers = 0

    def report(self):
        """What happened since the last report."""
        self.process.stdin.write("report\n")
        self.process.stdin.flush()

        def look():
            check(self.alive() or len(self.out) > self.answers, f"the honest peer ended: {self.out[-1:]} {self.err[-3:]}")
            return len(self.out) > self.answers
        wait_until("the honest peer to report", look)
        self.answers += 1
        fields = dict(field.split("=", 1) for field in self.out[self.answers - 1].split())
        check("images" in fields, f"the honest peer failed: {self.out[self.answers - 1]}")
        return {key: value if key == "epoch" else int(value) for key, value in fields.items()}

    def wait_images(self, count, hang_s=HANG_S):
        got = [0]

        def look():
            got[0] += self.report()["images"]
            return got[0] >= count
        wait_until(lambda: f"{count} images; there are {got[0]}", look, hang_s)


class Run:
    """One attack on a renderer of its own."""

    def __init__(self, test, name, report):
        self.test, self.name, self.attack, self.is_report = test, name, ATTACKS[name], report
        self.faults, self.bytes, self.closed, self.stop_s = [], 0, 0, 0.0
        self.before = self.during = self.after = None
        self.mib = 0

    def measure(self, seconds, is_done=lambda: True, most_s=0):
        """Images a second, of the time that other processes left; and the honest peer's report. Longer until is_done(), but
        not than most_s."""
        pids = (self.renderer.process.pid, self.honest.process.pid)

        def own():
            return sum(process_s(pid) for pid in pids)
        self.honest.report()
        begin, (machine, processors), ours = time.monotonic(), machine_s(), own()
        def elapsed():
            return time.monotonic() - begin
        while (elapsed() < seconds or not is_done() and elapsed() < most_s) and self.renderer.alive() and self.honest.alive():
            time.sleep(0.02)
        report = self.honest.report()
        wall = time.monotonic() - begin
        if not self.renderer.alive():
            return 0.0, report
        others = max(0.0, machine_s()[0] - machine - (own() - ours)) / processors
        return report["images"] / max(wall - others, wall / 3), report

    def run(self):
        scene = self.test.path("scene.glb")
        write_scene(scene)
        command = [self.test.programs_at["fire3dv"], scene, "--headless", "--on-request", "--cache", self.test.folder,
                   "--listen", "tcp://127.0.0.1:0", "--listen", "udp://127.0.0.1:0"]
        self.renderer = Program(self.test, "fire3dv", command, vulkan_environment())
        tcp, udp = (self.renderer.wait_err(rf"listening on ({kind}\S+)").group(1) for kind in ("tcp", "udp"))
        self.honest = Honest(self.test, tcp, *self.attack.honest)
        self.honest.wait_images(24)
        self.before, report = self.measure(BEFORE_S)
        self.expect_same(report, "undisturbed")
        check(report["unmatched"] == 0, "the honest peer's nodes are not in the scene")
        pid = self.renderer.process.pid
        with open(f"/proc/{pid}/clear_refs", "w", encoding="ascii") as file:
            file.write("5")  # resets VmHWM
        idle = memory_kib(pid, "VmRSS")
        arguments = [f"tcp={tcp}", f"udp={udp}", f"epoch={report['epoch']}", "nodes=" + ",".join(NODES)]
        if self.attack.asset:
            asset = self.test.path("asset.glb")
            write_asset(asset, *self.attack.asset)
            arguments.append(f"asset={asset}")
        attacker = Program(self.test, "the attacker", [self.test.programs_at["greedy_peer"], "attack", self.name, *arguments])
        wait_until("the attack to begin", lambda: "begun" in attacker.out)
        self.during, report = self.measure(self.attack.during_s, lambda: "sent" in attacker.out or not attacker.alive(), MOST_DURING_S)
        self.longest_gap_ms = report["longest_gap_ms"]
        self.expect_same(report, "during the attack")
        if self.renderer.alive():
            self.mib = (memory_kib(pid, "VmHWM") - idle) >> 10
        if self.attack.newcomer and self.renderer.alive():
            self.expect_newcomer(tcp)
        if not self.attack.stop_under_attack:
            self.end(attacker)
            self.recover()
            if self.renderer.alive():
                self.mib = max(self.mib, (memory_kib(pid, "VmHWM") - idle) >> 10)
        self.stop()
        self.end(attacker)
        self.judge()

    def expect_same(self, report, when):
        if report["changed"]:
            self.faults.append(f"{report['changed']} of {report['images']} images differ {when}")

    def expect_newcomer(self, uri):
        newcomer = Honest(self.test, uri)
        try:
            newcomer.wait_images(1, REPORT_WAIT_S)
        except Failure:
            self.faults.append("a newcomer is not served")
        newcomer.kill()

    def recover(self):
        """After the attack: images come again."""
        if not self.renderer.alive():
            return
        try:
            self.honest.wait_images(1, REPORT_WAIT_S)
            self.after, report = self.measure(AFTER_S)
            self.longest_gap_ms = max(self.longest_gap_ms, report["longest_gap_ms"])
            self.expect_same(report, "after the attack")
        except Failure as failure:
            self.faults.append(f"no recovery: {failure}")

    def stop(self):
        if not self.renderer.alive():
            self.faults.append(f"the renderer ended with {self.renderer.process.returncode}: {self.renderer.err[-1:]}")
            return
        begin = time.monotonic()
        self.renderer.signal(signal.SIGTERM)
        try:
            self.renderer.process.wait(REPORT_WAIT_S)
        except subprocess.TimeoutExpired:
            self.renderer.kill()
        self.stop_s = time.monotonic() - begin
        if self.renderer.process.returncode != 0:
            self.faults.append(f"SIGTERM: the renderer ended with {self.renderer.process.returncode}")
        if self.stop_s > STOP_S:
            self.faults.append(f"SIGTERM: the renderer took {self.stop_s:.1f} s to end")

    def end(self, attacker):
        if not attacker.alive():
            return
        attacker.process.stdin.close()
        try:
            attacker.process.wait(REPORT_WAIT_S)
        except subprocess.TimeoutExpired:
            attacker.kill()
            return
        for reader in attacker.readers:
            reader.join(HANG_S)
        found = re.search(r"bytes=(\d+) closed=(\d+)", " ".join(attacker.out))
        if found:
            self.bytes, self.closed = int(found.group(1)), int(found.group(2))

    def judge(self):
        least = LEAST_RATIO if "--strict" in sys.argv or self.is_report else NOISY_RATIO
        if self.during < least * self.before:
            self.faults.append(f"the rate fell below {least} of the undisturbed one")
        if self.mib > self.attack.most_mib:
            self.faults.append(f"memory grew by more than {self.attack.most_mib} MiB")

    def row(self):
        after = "-" if self.after is None else f"{self.after:.0f}"
        return (f"| {self.name} | {self.bytes / 1e6:.2f} | {self.closed} | {self.before:.0f} | {self.during:.0f} | {after} | "
                f"{self.during / max(self.before, 1e-9):.2f} | {self.longest_gap_ms} | {self.mib} | {self.stop_s:.1f} | "
                f"{'; '.join(self.faults) or 'held'} |")


def run_attack(paths, name, report):
    """The last run, which is the first without faults."""
    for _ in range(1 if report else TRIES):
        test = Test(paths)
        try:
            run = Run(test, name, report)
            run.run()
        finally:
            test.end()
        if not run.faults:
            break
    return run


def main():
    programs = dict(zip(("fire3dv", "greedy_peer"), sys.argv[1:3]))
    check(len(programs) == 2, "give the programs: fire3dv greedy_peer")
    report = "--report" in sys.argv
    names = [argument for argument in sys.argv[3:] if not argument.startswith("--")] or list(ATTACKS)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    print("| attack | MB sent | closed | images/s before | during | after | ratio | longest gap, ms | memory, MiB | SIGTERM, s |"
          " verdict |\n|---|---|---|---|---|---|---|---|---|---|---|", flush=True)
    failed = []
    for name in names:
        run = run_attack(programs, name, report)
        print(run.row(), flush=True)
        if run.faults:
            failed.append(name)
    if failed and not report:
        print(f"FAILED {', '.join(failed)}")
        sys.exit(1)


if __name__ == "__main__":
    main()
