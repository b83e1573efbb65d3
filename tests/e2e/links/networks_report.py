#!/usr/bin/env python3
"""The table of docs/benchmarks/networks.md: the conditions of networks_test.py for a minute each, all at once.

  networks_report.py BIN_DIR
"""
import os
import sys

import hosts
from harness import Test
from networks_test import CONDITIONS, run_conditions
from image_reader import check

SECONDS, DOWN_AFTER_S, DOWN_S = 60, 10, 5


def row(name, result):
    total = result["frames"] + result["missing"]
    cells = [name, f"{100 * result['missing'] / total:.1f} %"]
    for way in ("interpolated", "latest"):
        score = result[way]
        cells += [f"{score['rms_mm']:.2f}", f"{score['max_mm']:.1f}", f"{score['behind_ms']:.0f}"]
    cells += [f"{result['latest']['rms_mm'] / max(result['interpolated']['rms_mm'], 1e-3):.1f}",
              f"{result['times_late']}, {result['times_lost']}", f"{result['end_kib'] - result['settled_kib']}"]
    return "| " + " | ".join(cells) + " |"


def main():
    check(len(sys.argv) == 2, __doc__)
    reason = hosts.why_not()
    check(not reason, reason)
    test = Test({name: os.path.join(os.path.abspath(sys.argv[1]), name) for name in ("fire3dv-impair", "fire3dv-motion")})
    try:
        results = run_conditions(test, CONDITIONS, SECONDS, DOWN_AFTER_S, DOWN_S)
    finally:
        test.end()
    print("| network | frames missing | interpolated: RMS, mm | most | ms behind | latest: RMS, mm | most | ms behind | ratio of RMS "
          "| late, lost | growth, KiB |")
    print("|---" + "|---:" * 10 + "|")
    for name, result in results.items():
        print(row(name, result))


if __name__ == "__main__":
    main()
