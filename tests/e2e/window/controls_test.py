#!/usr/bin/env python3
"""End-to-end test of the hands in the window: the mouse drags a body of a simulation in Python by a visible spring, and a
slider of the panel Controls sets its value."""
import fire3dv
from harness import main, wait_until
from image_reader import HALF_SQUARE, check, ranges_about, ranges_of, write_scene
from screen import grabs, on_a_screen

WINDOW, COLUMNS = (1280, 720), (270, 680)  # the image between the panels
SPRING = (0x40, 0xff, 0x80)
PULL_PX = (90, -60)


class Simulation:
    """A body that follows its drags, once it may, and a controller with a gain."""

    def __init__(self, stream):
        self.stream, self.time_ns, self.position, self.follows = stream, 0, [0.0, 0.0, 0.0], False
        self.drag = stream.controls.drag(stiffness=100)
        self.gain = stream.controls.slider("gain", 0, 10, value=2)

    def until(self, what, condition):
        """Steps until something has happened, and returns it."""
        def step():
            self.stream.events()
            for pull in self.drag.pulls if self.follows else []:
                self.position = [target - point for target, point in zip(pull.target, pull.node_point)]
            x, y, z = self.position
            self.time_ns += 10_000_000
            self.stream.publish(self.time_ns, [[1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z]])
            return condition()
        return wait_until(what, step)


def centre(screen, window):
    """Centre and width of the red square in the window."""
    box = screen.picture(window).box_of(ranges_of("red"), COLUMNS[0], sum(COLUMNS))
    return box and ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2, box[2] - box[0])


def spring_pixels(screen, window):
    return sum(row.count(1) for row in screen.picture(window).matches(ranges_about(SPRING, 24), COLUMNS[0], sum(COLUMNS)))


def start(test, screen):
    scene, uri = test.path("red.glb"), test.fresh_uri("shm")
    write_scene(scene, {"red": ((1, 0, 0), 0)}, place=0)
    renderer = test.viewer(scene, "--listen", uri, env=screen.env, size=WINDOW)
    return renderer, screen.window(renderer), uri


def grab(screen, window, simulation, x, y):
    screen.move(window, int(x), int(y))
    screen.key_down("ctrl")
    screen.press_here()
    simulation.until("a drag", lambda: simulation.drag.pulls)


def drag(test, screen):
    renderer, window, uri = start(test, screen)
    with fire3dv.Stream(uri, adapter_name="sim") as stream:
        stream.describe(["red"])
        simulation = Simulation(stream)
        simulation.until("the renderer", lambda: stream.poll().acked_sequence > 0)
        x, y, width = wait_until("the square", lambda: centre(screen, window))
        units_per_px = 2 * HALF_SQUARE / width
        grab(screen, window, simulation, x, y)
        [pull] = simulation.drag.pulls
        check(pull.node == "red" and max(map(abs, pull.node_point)) < HALF_SQUARE, f"{pull}")
        check(spring_pixels(screen, window) < 400, "there is a spring without a pull")
        screen.move(window, int(x + PULL_PX[0]), int(y + PULL_PX[1]))
        wanted = (PULL_PX[0] * units_per_px, -PULL_PX[1] * units_per_px)

        def is_pulled():  # a renderer that compiles for long is late, and goes on
            return simulation.drag.pulls and is_at(simulation.drag.pulls[0])

        def is_at(now):
            return all(abs(now.target[axis] - now.node_point[axis] - wanted[axis]) < 3 * units_per_px for axis in (0, 1))
        simulation.until("the target under the pointer", is_pulled)
        simulation.until("the spring", lambda: spring_pixels(screen, window) > 100)
        simulation.follows = True

        def is_there():
            now = centre(screen, window)
            return now and abs(now[0] - x - PULL_PX[0]) < 4 and abs(now[1] - y - PULL_PX[1]) < 4
        simulation.until("the square under the pointer", is_there)
        screen.release()
        screen.key_up("ctrl")
        simulation.until("its release", lambda: not simulation.drag.pulls)
        simulation.until("no spring", lambda: spring_pixels(screen, window) == 0)
        slide(screen, window, simulation)
        # A renderer that is gone holds nothing.
        simulation.follows = False
        grab(screen, window, simulation, x + PULL_PX[0], y + PULL_PX[1])
        renderer.kill()
        simulation.until("the release", lambda: not simulation.drag.pulls)


def slide(screen, window, simulation):
    # Two sliders: the gain, and the speed of the camera below it.
    x, y = simulation.until("two sliders", lambda: (lambda now: now and len(now) == 2 and now)(grabs(screen.picture(window))))[0]
    screen.press(window, x, y)
    for to in range(x, 246, 12):
        screen.move(window, to, y)
    screen.release()
    simulation.until("a larger gain", lambda: simulation.gain.value > 8)


if __name__ == "__main__":
    main({"drag": on_a_screen(drag, size=(1280, 800))}, ["fire3dv"], plain_images=True)
