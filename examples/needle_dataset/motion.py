"""Scripted motion of the needle data set: poses of all nodes, frame by frame. The same seed gives the same motion."""
import numpy as np

import scene
import shapes
import tissue

FRAME_S = 0.2  # of simulated time between two frames
DRIVER, FORCEPS = scene.INSTRUMENTS
UP = np.array([0.0, 1.0, 0.0])


def unit(vector):
    return vector / np.linalg.norm(vector)


def turn(axis, angle):
    """Rotation about an axis of unit length, (3, 3)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def axes(z, x_near):
    """Rotation whose +Z is z, and whose +X is as near to x_near as that allows."""
    x = unit(x_near - z * (x_near @ z))
    return np.column_stack([x, np.cross(z, x), z])


def pose(rotation, position):
    return np.column_stack([rotation, position])


def direction(around, up):
    return np.array([np.cos(up) * np.sin(around), np.sin(up), np.cos(up) * np.cos(around)])


class Wander:
    """A number that moves smoothly between two limits, by three slow waves."""

    def __init__(self, source, low, high, speed=1.0):
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        self._rates = speed * source.uniform(0.3, 1.6, 3)
        self._phases = source.uniform(0, 2 * np.pi, 3)
        self._shares = source.dirichlet([1.5] * 3)

    def __call__(self, time_s):
        return self._middle + self._half * 1.2 * np.clip(self._shares @ np.sin(self._rates * time_s + self._phases), -1 / 1.2, 1 / 1.2)


class Rope:
    """The thread: points at equal steps behind the needle's tail that fall onto the tissue."""

    STEPS = 10  # of the integration in a frame
    ROUNDS = 8  # of the length constraints in a step

    def __init__(self, surface, tail, direction_away, source):
        self._surface = surface
        along = np.arange(shapes.THREAD_JOINTS)[:, None] * shapes.THREAD_SEGMENT_M
        side = unit(np.cross(direction_away, UP))
        bends = 0.008 * np.sin(along / source.uniform(0.012, 0.022) + source.uniform(0, 6)) * side
        self._points = tail + 0.9 * along * direction_away + bends
        self._before = self._points.copy()
        for _ in range(6):
            self.move(tail, direction_away)

    def move(self, tail, tangent):
        """One frame: the first segment follows the tail and its direction. Returns the points, (n, 3)."""
        start = self._points[:2].copy()
        end = np.stack([tail, tail + shapes.THREAD_SEGMENT_M * tangent])
        for step in range(self.STEPS):
            speed = 0.90 * (self._points - self._before)
            self._before = self._points.copy()
            self._points = self._points + np.clip(speed, -0.0015, 0.0015) - 9.81 * (FRAME_S / self.STEPS) ** 2 * 0.25 * UP
            for _ in range(self.ROUNDS):
                self._points[:2] = start + (end - start) * (step + 1) / self.STEPS
                self._keep_lengths()
            self._keep_above()
        self._points[:2] = end
        return self._points

    def _keep_lengths(self):
        for distance, share in ((2, 0.10), (1, 1.0)):  # the longer one resists bending
            for first in range(distance + 1):
                a, b = self._points[first:-distance:distance + 1], self._points[first + distance::distance + 1]
                a, b = a[:len(b)], b[:len(a)]
                between = b - a
                length = np.linalg.norm(between, axis=1, keepdims=True)
                move = 0.5 * share * (1 - distance * shapes.THREAD_SEGMENT_M / np.maximum(length, 1e-9)) * between
                a += move
                b -= move

    def _keep_above(self):
        floor = self._surface.height(self._points[:, 0], self._points[:, 2]) + 1.3 * shapes.THREAD_RADIUS_M
        below = self._points[:, 1] < floor
        self._points[below, 1] = floor[below]
        self._before[below] = self._points[below]  # friction

    def joints(self):
        """Poses of the joints, (n, 3, 4): +X leads along the thread, without twist."""
        along = np.gradient(self._points, axis=0)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        side, poses = np.cross(along[0], [0.3, 0.8, 0.5]), []
        for tangent, point in zip(along, self._points):
            side = unit(side - tangent * (side @ tangent))
            poses.append(pose(np.column_stack([tangent, side, np.cross(tangent, side)]), point))
        return np.array(poses)


class Instrument:
    """Poses of an instrument that comes through a fixed port and whose wrist bends."""

    def __init__(self, source, around, bend_rad, roll):
        self._port = 0.145 * direction(around, source.uniform(0.62, 0.88))
        self._bends = [Wander(source, -bend_rad, bend_rad, 0.6) for _ in range(2)]
        self._roll = roll

    def jaws(self, tip, time_s):
        """Rotation of the jaws, whose +Z leads to their tip and whose X is the axis that they open about."""
        shaft = unit(tip - self._port)
        base = axes(shaft, np.cross(shaft, UP))
        bent = base @ turn(np.array([1.0, 0, 0]), self._bends[0](time_s)) @ turn(np.array([0, 1.0, 0]), self._bends[1](time_s))
        return bent @ turn(np.array([0, 0, 1.0]), self._roll(time_s))

    def poses(self, rotation, tip, reach, opening_rad):
        """Poses of its parts, (4, 3, 4): the point at reach metres from the jaws' pivot is at the tip."""
        pivot = tip - reach * rotation[:, 2]
        joint = pivot - shapes.PIVOT_M * rotation[:, 2]
        shaft = axes(unit(joint - self._port), rotation[:, 0])
        jaws = [pose(rotation @ turn(np.array([1.0, 0, 0]), side * opening_rad), pivot) for side in (-1, 1)]
        return np.array([pose(shaft, joint), pose(rotation, joint), *jaws])


class Sequence:
    """One scripted episode over one tissue surface: the needle is held by the driver, or lies on the tissue."""

    def __init__(self, seed, number, surfaces, views):
        """surfaces: indices of the tissue surfaces to choose from. views: number of cameras."""
        self._source = source = np.random.default_rng([seed, number])
        self._tissue = int(source.choice(surfaces))
        self._surface = tissue.Surface(self._tissue + 1)
        self._is_held, self._grasps = source.random() < 0.75, source.random() < 0.3
        self._place = [Wander(source, -0.013, 0.013, 0.7) for _ in range(2)]
        self._around = source.uniform(-np.pi, np.pi)
        side = source.choice([-1, 1])
        self._driver = Instrument(source, self._around + side * source.uniform(0.9, 1.7), 0.55, self._roll(source.uniform(-1.9, 1.9), 0.8))
        self._forceps = Instrument(source, self._around - side * source.uniform(0.9, 1.7), 0.45, self._roll(source.uniform(-1.5, 1.5), 0.6))
        self._lift = Wander(source, 0.002, source.uniform(0.008, 0.022))
        self._open = [Wander(source, 0.08, 0.42) for _ in range(2)]
        self._away = [Wander(source, -0.014, 0.014) for _ in range(4)]
        self._height = [Wander(source, 0.002, 0.012) for _ in range(2)]
        self._grip(source)
        self._lie(source)
        self._cameras = [self._camera(source, view) for view in range(views)]
        self._rope = None
        self._tint = source.uniform(0.65, 1.0) * source.uniform(0.88, 1.0, 3)
        self._lamp_color = np.array([1.0, 0.96, 0.90]) * source.uniform(0.92, 1.0, 3)
        self._brightness = source.uniform(0.7, 1.4) * np.array([1.0, source.uniform(0.25, 0.9)])

    def looks(self):
        """The tissue that is seen, the factor on its colour, and colour and relative brightness of both lamps."""
        return {"tissue": self._tissue, "tint": self._tint, "lamp_color": self._lamp_color, "brightness": self._brightness}

    def _roll(self, middle, half):
        return Wander(self._source, middle - half, middle + half, 0.7)

    def _grip(self, source):
        """Pose of the needle in the jaws' axes: the wire passes between the jaws along X, at a place of the arc."""
        share = source.uniform(0.22, 0.55)
        angle = np.pi * (1 + share)
        tangent, inward = np.array([-np.sin(angle), np.cos(angle), 0]), -np.array([np.cos(angle), np.sin(angle), 0])
        needle = np.column_stack([tangent, inward, np.cross(tangent, inward)])
        flip = np.diag([-1.0, 1.0, -1.0]) if source.random() < 0.5 else np.eye(3)
        tilted = turn(np.array([1.0, 0, 0]), source.uniform(-0.9, 0.9)) @ turn(UP, source.uniform(-0.4, 0.4)) @ flip
        rotation = tilted @ needle.T
        self._reach = shapes.JAW_M - source.uniform(0.0015, 0.004)
        self._grip_pose = pose(rotation, np.array([0, 0, self._reach]) - rotation @ shapes.arc(share))

    def _lie(self, source):
        x, z = source.uniform(-0.012, 0.012, 2)
        up = unit(UP + source.normal(0, 0.12, 3))
        rotation = axes(up * source.choice([-1, 1]), direction(source.uniform(-np.pi, np.pi), 0))
        self._lying = pose(rotation, np.array([x, float(self._surface.height(x, z)) + 0.0011, z]))

    def _camera(self, source, view):
        """Its direction about that of the endoscope, which is view 0, and its distance."""
        spread = 0.0 if view == 0 else 1.0
        return {"around": Wander(source, -0.10, 0.10, 0.5), "up": Wander(source, -0.08, 0.08, 0.5), "distance": Wander(source, 0.058, 0.100, 0.5),
                "roll": Wander(source, -0.35, 0.35, 0.5), "aim": [Wander(source, -0.008, 0.008, 0.6) for _ in range(2)],
                "offset": (spread * source.uniform(-0.6, 0.6), 0.85 + source.uniform(-0.12, 0.12) + spread * source.uniform(-0.12, 0.2))}

    def _eye(self, camera, centre, time_s):
        """world_from_camera: looks along -Z."""
        to_eye = direction(self._around + camera["offset"][0] + camera["around"](time_s), camera["offset"][1] + camera["up"](time_s))
        right = unit(np.cross(UP, to_eye))
        above = np.cross(to_eye, right)
        aim = centre + camera["aim"][0](time_s) * right + camera["aim"][1](time_s) * above
        rotation = np.column_stack([right, above, to_eye]) @ turn(np.array([0, 0, 1.0]), camera["roll"](time_s))
        return pose(rotation, aim + camera["distance"](time_s) * to_eye)

    def _above(self, point, margin):
        floor = float(self._surface.height(point[0], point[2])) + margin
        return np.array([point[0], max(point[1], floor), point[2]])

    def frame(self, index):
        """Poses by node, (3, 4) each, world_from_node. Call it for index 0, 1, 2 ...: the thread has a state."""
        time_s = index * FRAME_S
        if self._is_held:
            x, z = (each(time_s) for each in self._place)
            tip = np.array([x, float(self._surface.height(x, z)) + self._lift(time_s), z])
            jaws, reach, opening = self._driver.jaws(tip, time_s), self._reach, shapes.WIRE_RADIUS_M / self._reach
            at_jaws = pose(jaws, tip - reach * jaws[:, 2])
            needle = at_jaws[:, :3] @ self._grip_pose
            needle[:, 3] += at_jaws[:, 3]
        else:
            needle = self._lying
            tip = self._beside(needle, 0, time_s)
            jaws, reach, opening = self._driver.jaws(tip, time_s), shapes.JAW_M, self._open[0](time_s)
        poses = {scene.NEEDLE: needle, **dict(zip(scene.parts(DRIVER), self._driver.poses(jaws, tip, reach, opening)))}
        middle = needle[:, 3] + needle[:, :3] @ [0, -0.5 * shapes.NEEDLE_RADIUS_M, 0]
        poses.update(zip(scene.parts(FORCEPS), self._second(needle, time_s)))
        poses.update(zip(scene.joints(), self._thread(needle)))
        poses[scene.THREAD] = pose(np.eye(3), np.zeros(3))
        eyes = [self._eye(camera, middle, time_s) for camera in self._cameras]
        poses.update(zip(scene.views(len(eyes)), eyes))
        for name, side in zip(scene.LAMPS, (-0.004, 0.004)):
            poses[name] = pose(eyes[0][:, :3], eyes[0][:, 3] + side * eyes[0][:, 0])
        return poses

    def _beside(self, needle, instrument, time_s):
        """A place near the needle, above the tissue."""
        across, along = (each(time_s) for each in self._away[2 * instrument:2 * instrument + 2])
        middle = needle[:, 3]
        point = middle + np.array([across, self._height[instrument](time_s), along])
        return self._above(point, 0.003)

    def _second(self, needle, time_s):
        """The forceps: near the needle, or holding it behind its tip."""
        if self._grasps:
            tip, opening = needle[:, 3] + needle[:, :3] @ shapes.arc(0.86), 0.03
        else:
            tip, opening = self._beside(needle, 1, time_s), self._open[1](time_s)
        tip = self._above(tip, 0.0015)
        return self._forceps.poses(self._forceps.jaws(tip, time_s), tip, shapes.JAW_M - 0.0012, opening)

    def _thread(self, needle):
        tail = needle[:, 3] + needle[:, :3] @ shapes.arc(0.0)
        away = needle[:, :3] @ np.array([0, 1.0, 0])  # the arc's tangent at the tail, backwards
        if self._rope is None:
            self._rope = Rope(self._surface, tail, unit(away + direction(self._source.uniform(-np.pi, np.pi), 0)), self._source)
        self._rope.move(tail + 0.0003 * away, away)
        return self._rope.joints()
