#!/usr/bin/env python3
"""End-to-end test of streams between two hosts over impaired networks: streams stay live or recover, memory stays bounded,
and stale streams are marked.

  networks_test.py fire3dv publisher fire3dv-impair fire3dv-motion [CASE...]
"""
import json
import os
import signal
import sys
import time

import hosts
from harness import Program, main, shown, wait_until
from image_reader import check

MOST_GROWTH_KIB = 4096  # of a process of 20 to 40 MiB, over thousands of frames
MOST_RENDERER_GROWTH_KIB = 65536  # of a process of about 300 MiB that draws with a software device
EVENS = ["--delay", "50", "--jitter", "20"]

# name: transport, options of the relay, options of the sender
CONDITIONS = {
    "no loss": ("udp", EVENS, []),
    "1 % lost": ("udp", [*EVENS, "--loss", "1"], []),
    "5 % lost": ("udp", [*EVENS, "--loss", "5"], []),
    "20 % lost": ("udp", [*EVENS, "--loss", "20"], []),
    "25 % overtake": ("udp", [*EVENS, "--reorder", "25"], []),
    "20 % twice": ("udp", [*EVENS, "--duplicate", "20"], []),
    "1 Mbit/s": ("udp", [*EVENS, "--rate", "1000000"], ["--nodes", "20"]),
    "link down": ("udp", [*EVENS, "--loss", "1"], []),
    "TCP, 1 Mbit/s": ("tcp", [*EVENS, "--rate", "1000000"], ["--nodes", "200"]),
    "TCP, stalls": ("tcp", [*EVENS, "--stall-after", "40000", "--stall-for", "400"], []),
    "TCP, resets": ("tcp", [*EVENS, "--reset-after", "30000"], []),
    "TCP, link down": ("tcp", EVENS, []),
}


class Stream:
    """A sender, a relay and a watcher, each on its host."""

    def __init__(self, test, network, index, condition, seconds):
        self.name, (transport, relay, sender) = condition
        port, watching = 7000 + 2 * index, f"{transport}://{network.VIEW}:{7001 + 2 * index}"
        self.watch = Program(test, f"{self.name}: watch", [test.programs_at["fire3dv-motion"], "watch", watching, "--insecure",
                                                           "--json", "--seconds", str(seconds)], host=network.view)
        self.watch.wait_err("listening on")
        entrance = f"{transport}://{network.RELAY}:{port}"
        self.relay = Program(test, f"{self.name}: relay", [test.programs_at["fire3dv-impair"], entrance, watching, "--insecure",
                                                           "--seed", str(index + 1), *relay], host=network.between)
        self.relay.wait_err(" to ")
        self.send = Program(test, f"{self.name}: send", [test.programs_at["fire3dv-motion"], "send", entrance, *sender],
                            host=network.simulator)

    def lose_link(self, after_s, seconds):
        """Takes the link down until the stream is lost and at least for `seconds`; the stream must recover."""
        self.watch.wait_err("frames come")
        time.sleep(after_s)
        self.relay.signal(signal.SIGUSR1)
        self.watch.wait_err("motion: lost")
        time.sleep(max(seconds - 3, 0))  # a stream is lost after 3 s
        self.relay.signal(signal.SIGUSR2)
        self.watch.wait_err("motion: live")

    def result(self):
        self.watch.expect_exit(0)
        self.send.signal(signal.SIGTERM)
        self.send.expect_exit(0)
        self.relay.signal(signal.SIGTERM)
        self.relay.expect_exit(0)
        return json.loads(self.watch.out[-1])


def run_conditions(test, conditions, seconds, down_after_s, down_s):
    """Runs all conditions in parallel, except for the outages, which are sequential. Returns the watchers' results by
    name.
    """
    network = hosts.TwoHosts(test)
    streams = [Stream(test, network, i, condition, seconds) for i, condition in enumerate(conditions.items())]
    for stream in streams:
        if "down" in stream.name:
            stream.lose_link(down_after_s, down_s)
    return {stream.name: stream.result() for stream in streams}


def conditions(test):
    results = run_conditions(test, CONDITIONS, seconds=8, down_after_s=0, down_s=3)
    for name, result in results.items():
        text = f"{name}: {result}"
        check(result["frames"] > 20, f"frames do not come: {text}")
        check(result["end_kib"] - result["settled_kib"] < MOST_GROWTH_KIB, f"memory grows: {text}")
        print(f"  {name}: interpolated {result['interpolated']['rms_mm']:.2f} mm, latest {result['latest']['rms_mm']:.2f} mm")
    for name in ("5 % lost", "20 % lost"):
        check(results[name]["missing"] > 0, f"nothing is lost: {results[name]}")
    for name in ("link down", "TCP, link down"):
        check(results[name]["times_lost"] >= 1, f"the outage is not seen: {results[name]}")


def resident_kib(program):
    pid = program.process.pid
    with open(f"/proc/{pid}/statm", encoding="ascii") as statm:
        return int(statm.read().split()[1]) * os.sysconf("SC_PAGESIZE") // 1024


def state_of(frame):
    tag = shown(frame, "arm")
    return tag and tag["state"]


def is_marked(picture, color):
    """Checks the stripes: they start in the corner with the colour, and the upper edge has both colours at its centre."""
    edge = [picture.pixel(x, 0) for x in range(picture.width)]
    near = [p for p in edge if all(abs(a - b) < 12 for a, b in zip(p, color))]
    return len(near) > len(edge) // 4 and edge.count((0, 0, 0)) > len(edge) // 4


COLORS = {"late": (255, 176, 0), "lost": (230, 26, 26)}


def check_unmarked(renderer, frame):
    picture = renderer.picture(frame)
    check(not any(is_marked(picture, color) for color in COLORS.values()), f"a picture is marked: {frame}")


def held(test):
    """The renderer marks a stream whose link goes down, in the image and in frames.jsonl."""
    network = hosts.TwoHosts(test)
    uri = f"udp://{network.VIEW}:7001"
    # With separate clocks interpolation is the default.
    play = () if network.clocks_differ else ("--play", "interpolate")
    renderer = test.renderer("--insecure", *play, listen=[uri], host=network.view)
    renderer.uris()
    entrance = f"udp://{network.RELAY}:7000"
    relay = Program(test, "relay", [test.programs_at["fire3dv-impair"], entrance, uri, "--insecure", *EVENS, "--loss", "5"],
                    host=network.between)
    relay.wait_err(" to ")
    publisher = test.publisher(entrance, host=network.simulator)
    publisher.do("stream 60")
    frame = renderer.wait_frame("a live frame", lambda f: state_of(f) == "live")
    check_unmarked(renderer, frame)
    before_kib = resident_kib(renderer)
    relay.signal(signal.SIGUSR1)
    for states in (("late", "lost"), ("lost",)):  # a very slow renderer may see "lost" first
        frame = renderer.wait_frame(f"a picture that is {states}", lambda f, s=states: state_of(f) in s, frame["frame"] - 1)
        check(is_marked(renderer.picture(frame), COLORS[state_of(frame)]), f"a held picture is not marked: {frame}")
    sequence = shown(frame, "arm")["sequence"]
    relay.signal(signal.SIGUSR2)
    frame = renderer.wait_frame("it to live again", lambda f: state_of(f) == "live" and
                                shown(f, "arm")["sequence"] > sequence, frame["frame"])
    check_unmarked(renderer, frame)
    grown_kib = resident_kib(renderer) - before_kib
    check(grown_kib < MOST_RENDERER_GROWTH_KIB, f"the renderer has grown by {grown_kib} KiB")
    publisher.quit()
    renderer.stop()


def unmarked(test):
    """Negative control: on one machine a pausing simulator is not marked."""
    uri = test.fresh_uri("tcp")
    renderer = test.renderer(listen=[uri])
    publisher = test.publisher(uri)
    publisher.do("publish 3")
    check_unmarked(renderer, renderer.wait_frame("a pause", lambda f: state_of(f) in COLORS))
    publisher.quit()
    renderer.stop()


CASES = {"conditions": conditions, "held": held, "unmarked": unmarked}

if __name__ == "__main__":
    reason = hosts.why_not()
    if reason:
        print(f"skipped: {reason}")
        sys.exit(hosts.SKIPPED)
    main(CASES, ["fire3dv", "publisher", "fire3dv-impair", "fire3dv-motion"])
