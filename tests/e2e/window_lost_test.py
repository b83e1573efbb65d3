#!/usr/bin/env python3
"""A display that takes the window's surface away gets another one; a GPU that is gone ends the program in words."""
import os

from harness import main, wait_until
from pictures import check
from screen import SIZE, all_squares, on_a_screen


def environment(test, screen, what):
    return {**screen.env, "LD_PRELOAD": os.path.abspath(test.programs_at["lose"]), "LOSE": what, "LOSE_AT": "4"}


def surface(test, screen):
    renderer = test.renderer(headless=False, size=SIZE, env=environment(test, screen, "surface"))
    window = screen.window(renderer)
    wait_until("images after that", lambda: renderer.alive() and len(renderer.frames()) > 8)
    wait_until("all squares on the screen", lambda: all_squares(screen.picture(window)))
    renderer.stop()


def device(test, screen):
    renderer = test.renderer(headless=False, size=SIZE, env=environment(test, screen, "device"))
    check(renderer.wait() == 1, f"it ended with {renderer.process.returncode}:\n{renderer.stderr_text()}")
    check(renderer.find_err(r"device lost.*start it again"), renderer.stderr_text())


CASES = {f.__name__: on_a_screen(f) for f in (surface, device)}

if __name__ == "__main__":
    main(CASES, ["fire3dv", "lose"])
