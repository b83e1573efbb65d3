#!/usr/bin/env python3
"""The table of whole frames in docs/benchmarks/networks.md: 300 nodes at 60 Hz over UDP and TCP, on a bridge that loses IP
packets of both alike. As root.

  whole_frames_report.py BIN_DIR [SECONDS]
"""
import ctypes
import fcntl
import heapq
import json
import os
import random
import select
import signal
import socket
import struct
import sys
import time

import hosts
from harness import Program, Test
from image_reader import check

ROWS = [(transport, options, loss) for loss in (0, 1, 5, 30)
        for transport, options in (("udp", "?parity=off"), ("udp", ""), ("tcp", ""))]
DELAY_S = 0.025  # each way
RATE_HZ = 60
SUBNET, VIEW = "10.73.0", "10.73.0.2"


def bridge(loss, seed, ends):
    """Forwards Ethernet frames between two interfaces, and prints the bytes of IP packets, lost ones included."""
    sockets = []
    for end in ends:
        packets = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
        packets.bind((end, 0))
        sockets.append(packets)
    chance, queue, order, sent = random.Random(seed), [], 0, 0
    stopped = []
    signal.signal(signal.SIGTERM, lambda *_: stopped.append(True))
    print("ready", flush=True)
    while not stopped:
        wait_s = max(queue[0][0] - time.monotonic(), 0) if queue else 0.1
        for readable in select.select(sockets, [], [], wait_s)[0]:
            frame, address = readable.recvfrom(65536)
            is_ip = frame[12:14] == b"\x08\x00"
            if address[2] == socket.PACKET_OUTGOING:
                continue
            sent += (len(frame) - 14) * is_ip
            if is_ip and chance.random() < loss:
                continue
            order += 1
            other = sockets[1 - sockets.index(readable)]
            heapq.heappush(queue, (time.monotonic() + DELAY_S * is_ip, order, other, frame))
        while queue and queue[0][0] <= time.monotonic():
            _, _, to, frame = heapq.heappop(queue)
            to.send(frame)
    print(sent, flush=True)


def switch_offloads_off(end):
    """The kernel would leave checksums and packets of TCP to the device, which a bridge of packets is not."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        for command in (0x2c, 0x24, 0x1f, 0x19, 0x17):  # GRO, GSO, TSO, scatter-gather, checksums
            value = ctypes.create_string_buffer(struct.pack("II", command, 0))
            fcntl.ioctl(any_socket, 0x8946, struct.pack("16sP", end.encode(), ctypes.addressof(value)))  # SIOCETHTOOL


def run_row(test, transport, options, loss, seconds, seed):
    motion = test.programs_at["fire3dv-motion"]
    simulator, between, view = (hosts.Host(test, name) for name in ("simulator", "between", "view"))
    hosts.cable(simulator, between, "10.74.0")
    hosts.cable(between, view, "10.75.0")
    for host, address in ((simulator, f"{SUBNET}.1"), (view, VIEW)):
        host.run("ip", "address", "flush", "dev", "cable0")
        host.run("ip", "address", "add", f"{address}/24", "dev", "cable0")
        host.run(sys.executable, __file__, "--offloads", "cable0")
    for end in ("cable0", "cable1"):
        between.run("ip", "address", "flush", "dev", end)
        between.run(sys.executable, __file__, "--offloads", end)
    packets = Program(test, "bridge", [sys.executable, "-u", __file__, "--bridge", str(loss / 100), str(seed), "cable0", "cable1"],
                      host=between)
    hosts.wait_until("the bridge", lambda: packets.out)
    uri = f"{transport}://{VIEW}:7001"
    watch = Program(test, "watch", [motion, "watch", uri, "--insecure", "--json", "--seconds", str(seconds)], host=view)
    watch.wait_err("listening on")
    send = Program(test, "send", [motion, "send", uri + options, "--nodes", "300", "--rate", str(RATE_HZ)], host=simulator)
    watch.expect_exit(0)
    for program in (packets, send):
        program.signal(signal.SIGTERM)
        program.expect_exit(0)
    result = json.loads(watch.out[-1])
    total = seconds * RATE_HZ
    way = result["latest"]
    name = "TCP" if transport == "tcp" else "UDP, no parity" if options else "UDP"
    return (f"| {loss} % | {name} | {min(100 * result['frames'] / total, 100):.1f} % | {int(packets.out[-1]) / total / 1024:.1f} "
            f"| {way['behind_ms']:.0f} | {way['max_mm']:.0f} |")


def main():
    if sys.argv[1:2] == ["--bridge"]:
        return bridge(float(sys.argv[2]), int(sys.argv[3]), sys.argv[4:6])
    if sys.argv[1:2] == ["--offloads"]:
        return switch_offloads_off(sys.argv[2])
    check(len(sys.argv) in (2, 3), __doc__)
    reason = hosts.why_not()
    check(not reason, reason)
    seconds = int(sys.argv[2]) if len(sys.argv) == 3 else 30
    print("| loss | link | frames shown | KiB a frame | ms behind | most, ms |")
    print("|---:|---|---:|---:|---:|---:|")
    for seed, (transport, options, loss) in enumerate(ROWS):
        test = Test({"fire3dv-motion": os.path.join(os.path.abspath(sys.argv[1]), "fire3dv-motion")})
        try:
            print(run_row(test, transport, options, loss, seconds, seed), flush=True)
        finally:
            test.end()
    return None


if __name__ == "__main__":
    main()
