#!/usr/bin/env python3
"""Stand-in for a ROS 2 system: publishes a robot description and joint positions until it is interrupted.

ros2_stand_in.py ROBOT.urdf JOINT POSITION ...; e2e_cyclone_publisher is on the PATH.
"""
import subprocess
import sys
import time

description, *joints = sys.argv[1:]
with subprocess.Popen(["e2e_cyclone_publisher"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as publisher:
    def send(*lines):
        publisher.stdin.write("\n".join(lines) + "\n")
        publisher.stdin.flush()

    send("open robot_description", "open joint_states", f"text {description}")
    try:
        while publisher.poll() is None:
            send(f"joints {time.time_ns()} {' '.join(joints)}")
            time.sleep(0.05)
    except (KeyboardInterrupt, BrokenPipeError):
        pass
