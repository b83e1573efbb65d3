"""Robots of a ROS 2 system in images of fire3dv: added to a scene, in the scene already, and as a file that is reloaded."""
import sys
import time

from harness import main, wait_until
from hosts import SKIPPED, why_not
from image_reader import SIZE, check
from ros2_system import Ros, end, write

# A red box of 20 units: the scene of the tests has a unit a pixel, its camera looks along Y of ROS.
BOX = """<robot name="box">
  <link name="base"/>
  <link name="box"><visual><geometry><box size="{0} {0} {0}"/></geometry><material name="red"><color rgba="1 0 0 1"/></material>
  </visual></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="box"/><axis xyz="1 0 0"/>
    <limit lower="-100" upper="100" effort="1" velocity="1"/></joint>
</robot>
"""


def is_red(picture, x, z):
    red, green, blue = picture.pixel(SIZE[0] // 2 + x, SIZE[1] // 2 - z)
    return red > 40 and red > 2 * green and red > 2 * blue


def publish_until(side, renderer, what, transforms, wanted):
    """Publishes these transforms (parent, child, x, y, z) again and again, until a picture is as wanted."""
    def look():
        publish_until.seconds += 0.1
        side.send("tf", *[(parent, child, publish_until.seconds, *numbers) for parent, child, *numbers in transforms])
        time.sleep(0.1)
        frames = renderer.frames()
        return frames and wanted(renderer.picture(frames[-1]))
    wait_until(lambda: f"{what}:\n{renderer.stderr_text()}", look)


publish_until.seconds = 100


def start(test, ros, *arguments, scene=None):
    renderer = test.renderer(listen=[ros.uri], scene=scene)
    renderer.uris()
    adapter = ros.adapter(*arguments)
    side = ros.side(opens=["robot_description", "tf", "tf_static"])
    side.do("text " + write(test, "box.urdf", BOX.format(20)))
    return renderer, adapter, side


def too_deep(test):
    """A robot whose nodes have paths that are too long for a stream is not sent, with a warning; poses go on."""
    ros = Ros(test, dumps=False)
    links = ["l%02d" % i + "x" * 60 for i in range(30)]
    joints = "".join(f'<joint name="j{i}" type="revolute"><parent link="{parent}"/><child link="{child}"/><axis xyz="1 0 0"/>'
                     '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
                     for i, (parent, child) in enumerate(zip(links, links[1:])))
    renderer = test.renderer(listen=[ros.uri])
    renderer.uris()
    adapter = ros.adapter()
    side = ros.side(opens=["robot_description", "tf", "tf_static"])
    side.do("text " + write(test, "deep.urdf", '<robot name="deep">' + "".join(f'<link name="{link}"/>' for link in links) +
                            joints + "</robot>"))
    adapter.wait_err("cannot describe the frames to .*; it is not sent: write it to a file .--write-scene.")
    before = len(renderer.frames())
    publish_until(side, renderer, "frames", [("map", links[0], 0, 0, 0)], lambda _: len(renderer.frames()) > before)
    end(adapter)
    renderer.stop()


def added(test):
    """A scene without the robot gets it, moves it, and loses it with the adapter; a renderer that starts again has it, too."""
    ros = Ros(test, dumps=False)
    renderer, adapter, side = start(test, ros)
    adapter.wait_err(r"the robot was sent to shm://\S+, whose scene does not have it")
    base = ("map", "base", 0, 0, -20)
    publish_until(side, renderer, "the box at -40", [base, ("base", "box", -40, 0, 0)],
                  lambda picture: is_red(picture, -40, -20) and not is_red(picture, 20, -20))
    publish_until(side, renderer, "the box at 20", [base, ("base", "box", 20, 0, 0)],
                  lambda picture: is_red(picture, 20, -20) and not is_red(picture, -40, -20))
    side.do("text " + write(test, "small.urdf", BOX.format(8)))
    publish_until(side, renderer, "a smaller box", [base, ("base", "box", 20, 0, 0)],
                  lambda picture: is_red(picture, 20, -20) and not is_red(picture, 28, -20))
    renderer.kill()
    renderer = test.renderer(listen=[ros.uri])
    renderer.uris()
    publish_until(side, renderer, "the box in the second renderer", [base, ("base", "box", 20, 0, 0)],
                  lambda picture: is_red(picture, 20, -20) and not is_red(picture, 28, -20))
    end(adapter)
    renderer.stop()


def known(test):
    """A scene that has the robot does not get it; the file of --write-scene is reloaded when the description changes."""
    ros = Ros(test, dumps=False)
    scene = test.path("robot.glb")
    side = ros.side(opens=["robot_description", "tf"], wait=False)
    side.do("text " + write(test, "box.urdf", BOX.format(20)))
    adapter = ros.adapter("--write-scene", scene)
    adapter.wait_err("wrote ")
    renderer = test.renderer("--watch", "on", listen=[ros.uri], scene=scene)
    renderer.uris()
    side.wait_readers("tf")
    publish_until(side, renderer, "a box", [("map", "base", 0, 0, 0), ("base", "box", 0, 0, 0)],
                  lambda picture: is_red(picture, 0, 0))
    side.do("text " + write(test, "blue.urdf", BOX.format(20).replace("1 0 0 1", "0 0 1 1")))
    renderer.wait_err("reloaded .*robot.glb")

    def is_blue(picture):
        red, green, blue = picture.pixel(SIZE[0] // 2, SIZE[1] // 2)
        return blue > 40 and blue > 2 * red and blue > 2 * green
    publish_until(side, renderer, "a blue box", [("map", "base", 0, 0, 0), ("base", "box", 0, 0, 0)], is_blue)
    end(adapter)
    adapter = ros.adapter()
    side.wait_readers("tf")
    publish_until(side, renderer, "the box without a file", [("map", "base", 0, 0, 0), ("base", "box", 0, 0, 0)],
                  lambda picture: is_blue(picture) and adapter.find_err("2 frames in"))
    time.sleep(1)
    check(not adapter.find_err("the robot was sent"), adapter.stderr_text())
    end(adapter)
    renderer.stop()


if __name__ == "__main__":
    reason = why_not()
    if reason:
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    main({"added": added, "known": known, "too_deep": too_deep}, ["fire3dv", "fire3dv-ros2", "publisher"])
