#!/usr/bin/env python3
"""End-to-end test of frames of many datagrams over networks that lose some: parity restores them. 300 nodes at 60 Hz.

  whole_frames_test.py fire3dv-impair fire3dv-motion fire3dv-record [CASE...]
"""
import re
import signal

from harness import Program, main
from image_reader import check

NODES, RATE_HZ = 300, 60


def whole_frames(test, seconds, options="", impair=()):
    """Returns the share of published frames that a recorder has whole, and its program."""
    inlet, outlet = test.fresh_uri("udp"), test.fresh_uri("udp")
    record = Program(test, "record", [test.programs_at["fire3dv-record"], "--from", outlet, "--out", test.path(f"out{len(test.programs)}.mcap")])
    record.wait_err("listening on")
    relay = Program(test, "relay", [test.programs_at["fire3dv-impair"], inlet, outlet, *impair])
    relay.wait_err(" to ")
    send = Program(test, "send", [test.programs_at["fire3dv-motion"], "send", inlet + options, "--nodes", str(NODES),
                                  "--rate", str(RATE_HZ), "--seconds", str(seconds)])
    send.expect_exit(0)
    record.signal(signal.SIGINT)
    record.wait()
    relay.signal(signal.SIGTERM)
    relay.expect_exit(0)
    said = "\n".join(record.out + record.err)
    counts = re.search(r"(\d+) frames.* (\d+) incomplete", said)
    check(counts, f"nothing was recorded: {said}")
    frames, incomplete = int(counts.group(1)), int(counts.group(2))
    share = (frames - incomplete) / (seconds * RATE_HZ)
    print(f"  {' '.join(impair)} {options}: {100 * share:.2f} % of frames; relay: {relay.out[-1]}")
    return share, record


def lossy(test):
    for loss, least in (("5", 0.99), ("30", 0.90)):
        share, _ = whole_frames(test, 20, impair=("--loss", loss))
        check(share >= least, f"of the frames {100 * share:.1f} % are whole at {loss} % loss")


def without_parity(test):
    """Negative control: the same network without parity."""
    share, _ = whole_frames(test, 5, "?parity=off", ("--loss", "5"))
    check(share < 0.8, "the network loses nothing: the test proves nothing")


def black_hole(test):
    """Datagrams of the usual length are lost without a word; the publisher finds shorter ones, and the log says so."""
    share, record = whole_frames(test, 10, impair=("--mtu", "600"))
    check(share > 0.4, "frames are missing")  # the search takes seconds
    check(record.find_err(r"lost on the way.*\?mtu=576"), f"no hint: {record.stderr_text()}")


def jitter(test):
    """Datagrams of many frames arrive mixed; nothing is lost."""
    share, _ = whole_frames(test, 6, impair=("--delay", "200", "--jitter", "100"))
    check(share > 0.6, f"frames are missing: {share}")


CASES = {"lossy": lossy, "without_parity": without_parity, "black_hole": black_hole, "jitter": jitter}

if __name__ == "__main__":
    main(CASES, ["fire3dv-impair", "fire3dv-motion", "fire3dv-record"])
