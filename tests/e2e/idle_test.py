#!/usr/bin/env python3
"""End-to-end test of idle renderers: without a receiver of images, only changes are drawn, and a wait names its cause."""
import os
import signal
import time

from harness import Program, check, main, vulkan_environment, wait_until
from prometheus import images_of, settled, url_of
from screen import on_a_screen

IDLE_S = 4
# Measured: 0.7 % of a core on a busy machine. The kernel counts CPU time in steps of 10 ms, hence the larger limit.
MAX_IDLE_CORES = 0.02


def cpu_s(program):
    """CPU time of all threads of a program."""
    with open(f"/proc/{program.process.pid}/stat", encoding="ascii") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def headless(test, *arguments):
    return Program(test, "fire3dv", [test.programs_at["fire3dv"], test.scene, "--headless", "--size", "64x36", "--cache", "off",
                                     "--validation", *arguments], vulkan_environment())


def expect_idle(program, url, drawn):
    """The program draws nothing, and uses hardly any CPU time."""
    used = cpu_s(program)
    time.sleep(IDLE_S)
    used = cpu_s(program) - used
    print(f"{program.name}: {100 * used / IDLE_S:.2f} % of a core")
    check(used < MAX_IDLE_CORES * IDLE_S, f"{used} s of CPU time in {IDLE_S} s")
    check(images_of(url) == drawn, "it drew an unchanged scene")


def draws_changes_only(test):
    uri = test.fresh_uri("shm")
    renderer = headless(test, "--listen", uri, "--metrics", "127.0.0.1:0", "--no-validation")
    url = url_of(renderer)
    wait_until("the first image", lambda: images_of(url) > 0)
    drawn = settled(url)
    expect_idle(renderer, url, drawn)

    publisher = test.publisher(uri)
    publisher.wait_welcome()
    for _ in range(3):  # each frame is shown and acknowledged, though the renderer was idle
        sequence = publisher.do("publish 1")["sequence"]
        publisher.wait_status("the frame", lambda s, n=sequence: s["acked"] == n)
        before, drawn = drawn, settled(url)
        check(before < drawn <= before + 10, f"{drawn - before} images of one frame")
    publisher.do("hide red")
    wait_until("an image of the edit", lambda: images_of(url) > drawn)
    drawn = settled(url)
    publisher.quit()
    wait_until("an image without the stream", lambda: images_of(url) > drawn)
    settled(url)
    renderer.signal(signal.SIGTERM)
    renderer.expect_exit()


def window_draws_changes_only(test, screen):
    viewer = test.viewer(test.scene, "--gui", "off", "--metrics", "127.0.0.1:0", "--no-validation", env=screen.env)
    url = url_of(viewer)
    window = screen.window(viewer)
    wait_until("the first image", lambda: images_of(url) > 0)
    drawn = settled(url)
    expect_idle(viewer, url, drawn)
    before = screen.picture(window).rows
    screen.press(window, 60, 40)
    screen.move(window, 90, 45)
    screen.release()
    wait_until("the turned scene", lambda: screen.picture(window).rows != before)
    check(settled(url) > drawn, "nothing was drawn for the mouse")
    viewer.signal(signal.SIGTERM)
    viewer.expect_exit()


def names_what_it_waits_for(test):
    uri = test.fresh_uri("shm")
    renderer = headless(test, "--listen", uri, "--lockstep", "--frames", "5")
    publisher = test.publisher(uri)
    publisher.do("lockstep 2")
    publisher.quit()
    said = renderer.wait_err("all streams have ended; waiting for another one at shm://")
    check("3 of 5 images to draw" in said.string and "--lockstep" in said.string and "--exit-when-done" in said.string,
          said.string)
    time.sleep(4)
    check(sum("waiting for" in line for line in renderer.err) == 1, renderer.stderr_text())
    renderer.signal(signal.SIGTERM)
    renderer.expect_exit()

    late = headless(test, "--listen", uri, "--exit-when-done")
    said = late.wait_err("waiting for a stream at shm://")
    check("--exit-when-done exits after the first stream that starts from now on" in said.string, said.string)
    publisher = test.publisher(uri)
    publisher.do("publish 1")
    publisher.wait_welcome()
    publisher.quit()
    late.expect_exit()


if __name__ == "__main__":
    main({"draws_changes_only": draws_changes_only, "window_draws_changes_only": on_a_screen(window_draws_changes_only),
          "names_what_it_waits_for": names_what_it_waits_for}, ["fire3dv", "publisher"])
