#!/usr/bin/env python3
"""End-to-end test of the joint sliders: a slider of the window, dragged by the mouse, moves the robot's body."""
from harness import main, wait_until
from screen import grabs, on_a_screen

WINDOW = (1280, 720)
URDF = """<robot name="lift"><link name="base"><visual><geometry><box size="1 1 0.1"/></geometry></visual>
<visual><origin xyz="-0.45 0 0.8"/><geometry><box size="0.05 0.05 1.6"/></geometry></visual></link>
<link name="car"><visual><geometry><box size="0.4 0.4 0.4"/></geometry>
<material name="red"><color rgba="1 0 0 1"/></material></visual></link>
<joint name="lift" type="prismatic"><parent link="base"/><child link="car"/><origin xyz="0 0 0.3"/>
<axis xyz="0 0 1"/><limit lower="0" upper="0.8" effort="1" velocity="1"/></joint></robot>
"""


def top_of_the_car(picture):
    middle = picture.width // 2
    box = picture.box_of([(91, 255), (0, 59), (0, 59)], middle, middle + 1)
    return box[1] if box else None


def drag(test, screen):
    scene = test.path("lift.urdf")
    with open(scene, "w", encoding="ascii") as file:
        file.write(URDF)
    renderer = test.viewer(scene, "--background", "204080", env=screen.env, size=WINDOW)
    window = screen.window(renderer)
    before = wait_until("the car", lambda: top_of_the_car(screen.picture(window)))
    # Two sliders: the joint's, and the speed of the camera below it.
    joint = wait_until("two sliders", lambda: (lambda now: now and len(now) == 2 and now)(grabs(screen.picture(window))))[0]
    screen.press(window, *joint)
    for x in range(joint[0], 246, 12):
        screen.move(window, x, joint[1])
    screen.release()
    wait_until("a car that has risen", lambda: (top_of_the_car(screen.picture(window)) or before) < before - 60)
    screen.x11.close(window)
    renderer.wait_err("close again to discard it")
    screen.x11.close(window)
    renderer.expect_exit(0)


if __name__ == "__main__":
    main({"drag": on_a_screen(drag, size=(1280, 800))}, ["fire3dv"], plain_images=True)
