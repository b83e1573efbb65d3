#!/usr/bin/env python3
"""Soak: four honest peers over shared memory, TCP (two) and UDP, a hostile one that changes its attack each minute, and one that
comes and goes, while the renderer records. Prints a line for each interval: rates, memory, threads, descriptors.

soak_test.py FIRE3DV FIRE3DV_INSPECT GREEDY_PEER RECORD_SOURCE [--minutes N] [--report]; an hour is --minutes 60. Default:
FIRE3DV_SOAK_MINUTES, or 3. --report fails for nothing.

At the end: the renderer lives and ends on SIGTERM, nobody's rate was below LEAST_RATIO of the first interval's, nothing grew,
and the recording is whole for the streams whose peers lost nothing."""
import argparse
import json
import os
import signal
import subprocess
import sys
import time

from greedy_peers_test import ATTACKS, NODES, Honest, memory_kib
from greedy_scene import write_asset, write_scene
from harness import HANG_S, Program, Test, vulkan_environment, wait_until
from image_reader import Failure, check

LEAST_RATIO = 0.3  # two loaded cores vary by a third; --report shows the figures
MOST_GROWTH_MIB = 150  # of the last interval without an attack over the first one
UDP_RATE_HZ = 60
VISIT_S = 4


class Soak:
    def __init__(self, test, minutes):
        self.test = test
        self.interval_s = min(60.0, minutes * 60 / 6)
        self.intervals = max(3, round(minutes * 60 / self.interval_s))
        self.rows, self.faults = [], []

    def start(self):
        test = self.test
        scene, self.recording = test.path("scene.glb"), test.path("soak.mcap")
        write_scene(scene)
        self.asset = test.path("asset.glb")
        self.shm = test.fresh_uri("shm")
        command = [test.programs_at["fire3dv"], scene, "--headless", "--on-request", "--cache", test.folder, "--record", self.recording,
                   "--listen", "tcp://127.0.0.1:0", "--listen", "udp://127.0.0.1:0", "--listen", self.shm]
        self.renderer = Program(test, "fire3dv", command, vulkan_environment())
        self.tcp, self.udp = (self.renderer.wait_err(rf"listening on ({kind}\S+)").group(1) for kind in ("tcp", "udp"))
        self.honest = {"shm": Honest(test, self.shm), "tcp": Honest(test, self.tcp), "tcp, edits": Honest(test, self.tcp, "edits")}
        self.source = Program(test, "source", [test.programs_at["source"], self.udp, "steady", str(10**9), str(UDP_RATE_HZ), "20"])
        for peer in self.honest.values():
            peer.wait_images(3)
        self.epoch = self.honest["tcp"].report()["epoch"]
        self.visitor, self.visits, self.visit_until = None, 0, 0.0

    def visit(self):
        """The peer that comes and goes: every second time it is killed."""
        if time.monotonic() < self.visit_until:
            return
        self.visit_until = time.monotonic() + VISIT_S
        if self.visitor:
            if self.visits % 2:
                self.visitor.kill()
            else:
                self.visitor.process.stdin.close()
                self.visitor.wait()
            self.test.programs.remove(self.visitor)
            self.visitor = None
            return
        self.visits += 1
        self.visitor = Honest(self.test, self.tcp)

    def attacker(self, name):
        attack = ATTACKS[name]
        arguments = [f"tcp={self.tcp}", f"udp={self.udp}", f"epoch={self.epoch}", "nodes=" + ",".join(NODES)]
        if attack.asset:
            write_asset(self.asset, *attack.asset)
            arguments.append(f"asset={self.asset}")
        return Program(self.test, name, [self.test.programs_at["greedy_peer"], "attack", name, *arguments])

    def interval(self, name):
        attacker = self.attacker(name) if name else None
        for peer in self.honest.values():
            peer.report()
        begin = time.monotonic()
        while time.monotonic() < begin + self.interval_s and self.renderer.alive():
            self.visit()
            time.sleep(0.1)
        check(self.renderer.alive(), f"the renderer ended during {name}:\n{self.renderer.stderr_text()[-2000:]}")
        wall = time.monotonic() - begin
        reports = {kind: peer.report() for kind, peer in self.honest.items()}
        pid = self.renderer.process.pid
        self.rows.append({"attack": name or "none", **{kind: report["images"] / wall for kind, report in reports.items()},
                          "gap_ms": max(report["longest_gap_ms"] for report in reports.values()),
                          "rss": memory_kib(pid, "VmRSS") >> 10, "threads": len(os.listdir(f"/proc/{pid}/task")),
                          "fds": len(os.listdir(f"/proc/{pid}/fd")), "file": os.path.getsize(self.recording) / 1e6})
        self.print_row(len(self.rows), self.rows[-1])
        if not attacker:
            return
        attacker.process.stdin.close()
        try:
            attacker.process.wait(HANG_S)
        except subprocess.TimeoutExpired:
            attacker.kill()
        self.test.programs.remove(attacker)

    @staticmethod
    def print_row(number, row):
        print(f"| {number} | {row['attack']} | {row['shm']:.1f} | {row['tcp']:.1f} | {row['tcp, edits']:.1f} | {row['gap_ms']} | "
              f"{row['rss']} | {row['threads']} | {row['fds']} | {row['file']:.1f} |", flush=True)

    def run(self):
        self.start()
        print("| interval | attack | shm, images/s | tcp, images/s | tcp with edits, images/s | longest gap, ms | memory, MiB | threads | "
              "descriptors | recording, MB |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |", flush=True)
        names = list(ATTACKS)
        for number in range(self.intervals):
            is_calm = number in (0, self.intervals - 1)
            self.interval(None if is_calm else names[(number - 1) % len(names)])
        self.end()

    def end(self):
        first, last = self.rows[0], self.rows[-1]
        for kind in self.honest:
            for row in self.rows:
                if row[kind] < LEAST_RATIO * first[kind]:
                    self.faults.append(f"{kind} fell to {row[kind]:.1f} of {first[kind]:.1f} images/s during {row['attack']}")
        if last["rss"] > first["rss"] + MOST_GROWTH_MIB:
            self.faults.append(f"memory grew from {first['rss']} to {last['rss']} MiB")
        if last["threads"] > first["threads"] + 2 or last["fds"] > first["fds"] + 8:
            self.faults.append(f"threads {first['threads']} to {last['threads']}, descriptors {first['fds']} to {last['fds']}")
        published = {kind: peer.report()["lost"] for kind, peer in self.honest.items()}
        for program in [*self.honest.values(), self.source, *([self.visitor] if self.visitor else [])]:
            program.process.stdin.close()
            if program is self.source:
                program.kill()
            program.process.wait(HANG_S)
        self.renderer.signal(signal.SIGTERM)
        code = self.renderer.wait()
        if code not in (0, 1) or (code == 1 and not self.renderer.find_err("the recording is incomplete: .* lacks ")):
            self.faults.append(f"the renderer ended with {code}: {self.renderer.err[-1:]}")
        done = subprocess.run([self.test.programs_at["inspect"], "--json", self.recording], capture_output=True, text=True, timeout=HANG_S)
        said = json.loads(done.stdout)
        poses = [(t["topic"], t["frames"], t["missing"]) for t in said["topics"] if t["topic"].endswith("/poses") and t["frames"] > 100]
        print(f"visits: {self.visits}; images that were waited for in vain: {published}; the renderer's last words:")
        print("\n".join(self.renderer.err[-3:]))
        for topic, frames, missing in poses:
            print(f"{topic}: {frames} frames, {missing} missing")
        if not said["sound"]:
            self.faults.append("the recording is damaged")
        self.faults += [f"the recording lacks {missing} frames of {topic}" for topic, _, missing in poses
                        if missing and "steady" not in topic]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("programs", nargs=4)
    parser.add_argument("--minutes", type=float, default=float(os.environ.get("FIRE3DV_SOAK_MINUTES", "3")))
    parser.add_argument("--report", action="store_true")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    test = Test(dict(zip(("fire3dv", "inspect", "greedy_peer", "source"), options.programs)))
    try:
        soak = Soak(test, options.minutes)
        soak.run()
        print("\n".join(soak.faults) or "held")
        sys.exit(1 if soak.faults and not options.report else 0)
    except Failure as failure:
        print(f"FAILED: {failure}")
        sys.exit(1)
    finally:
        test.end()


if __name__ == "__main__":
    main()
