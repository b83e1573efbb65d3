"""Test of fire3dv.pose and look_at against rotations about axes, compositions of quaternions and projections."""
import math
import warnings

import numpy as np

import fire3dv


def refused(text, call):
    try:
        call()
    except fire3dv.ArgumentError as error:
        assert text in str(error), error
        return
    raise AssertionError(f"nothing was raised, expected: {text}")


def close(found, wanted):
    assert found.dtype == np.float32 and found.flags.c_contiguous, found
    assert found.shape == np.shape(wanted) and np.allclose(found, wanted, atol=1e-6), (found, wanted)


def about(axis, angle):
    """x, y, z, w."""
    return np.append(math.sin(angle / 2) * np.array(axis, float), math.cos(angle / 2))


c, s = math.cos(0.3), math.sin(0.3)
turns = {(1, 0, 0): [[1, 0, 0], [0, c, -s], [0, s, c]], (0, 1, 0): [[c, 0, s], [0, 1, 0], [-s, 0, c]],
         (0, 0, 1): [[c, -s, 0], [s, c, 0], [0, 0, 1]]}
for axis, matrix in turns.items():
    wanted = np.column_stack([matrix, [1, 2, 3]])
    close(fire3dv.pose((1, 2, 3), about(axis, 0.3)), wanted)
    close(fire3dv.pose((1, 2, 3), wxyz=np.roll(about(axis, 0.3), 1)), wanted)
    close(fire3dv.pose(quaternion=-about(axis, 0.3)), np.column_stack([matrix, [0, 0, 0]]))  # q and -q are one rotation
close(fire3dv.pose(), np.eye(3, 4))
close(fire3dv.pose((1, 2, 3)), np.column_stack([np.eye(3), [1, 2, 3]]))

# The matrix of a product of quaternions is the product of their matrices.
source = np.random.default_rng(3)
p, q = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in source.normal(size=(2, 20, 4)))
product = np.column_stack([p[:, 3:] * q[:, :3] + q[:, 3:] * p[:, :3] + np.cross(p[:, :3], q[:, :3]),
                           p[:, 3] * q[:, 3] - (p[:, :3] * q[:, :3]).sum(axis=1)])
places = source.normal(size=(20, 3))
close(fire3dv.pose(places, product),
      np.concatenate([fire3dv.pose(quaternion=p)[..., :3] @ fire3dv.pose(quaternion=q)[..., :3], places[..., None]], axis=2))
close(fire3dv.pose(places), np.concatenate([np.tile(np.eye(3), (20, 1, 1)), places[..., None]], axis=2))
assert (fire3dv.pose((1, 2, 3), p)[:, :, 3] == (1, 2, 3)).all()
close(fire3dv.pose(places, p[0]), np.stack([fire3dv.pose(place, p[0]) for place in places]))

refused("quaternion has the length 2", lambda: fire3dv.pose(quaternion=(0, 0, 0, 2)))
refused("wxyz[1] has the length 0", lambda: fire3dv.pose(wxyz=[(1, 0, 0, 0), (0, 0, 0, 0)]))
refused("quaternion[2] is nan", lambda: fire3dv.pose(quaternion=(0, 0, math.nan, 1)))
refused("position[1][0] is inf", lambda: fire3dv.pose([(0, 0, 0), (math.inf, 0, 0)]))
refused("position has the shape (4,); (3,) or (n, 3)", lambda: fire3dv.pose((0, 0, 0, 1)))
refused("quaternion has the shape (2, 3)", lambda: fire3dv.pose(quaternion=np.zeros((2, 3))))
refused("2 positions for 20 quaternions", lambda: fire3dv.pose(places[:2], p))
refused("exclude each other", lambda: fire3dv.pose((0, 0, 0), p[0], wxyz=p[0]))
refused("position must hold numbers", lambda: fire3dv.pose("abc"))

# The target is on the camera's -Z axis, and up is above it.
for up in ((0, 1, 0), (0, 0, 1), (0.3, 2, -1)):
    eye, target = np.array([3, -2, 5.0]), np.array([0.5, 1, 0])
    view = fire3dv.look_at(eye, target, up)
    close(view[:, 3].copy(), eye)
    close(view[:, :3] @ view[:, :3].T, np.eye(3))
    assert np.linalg.det(view[:, :3]) > 0.999
    close(view[:, :3].T @ (target - eye).astype(np.float32), [0, 0, -np.linalg.norm(target - eye)])
    above = view[:, :3].T @ np.array(up, np.float32)
    assert abs(above[0]) < 1e-6 and above[1] > 0, above
refused("eye and target are the same point, (1.0, 2.0, 3.0)", lambda: fire3dv.look_at((1, 2, 3), (1, 2, 3)))
refused("up is (0.0, 0.0, 1.0), which is zero or along the view", lambda: fire3dv.look_at((0, 0, 1), (0, 0, 5), (0, 0, 1)))
refused("eye has the shape (2, 3); (3,) is needed", lambda: fire3dv.look_at(np.zeros((2, 3)), (1, 0, 0)))

# One pose goes to publish as it is. An array that was never filled is reported once.
with fire3dv.Stream("udp://127.0.0.1:9") as stream, warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    stream.describe(["a", "b"])
    for _ in range(2):
        stream.publish(0, np.stack([fire3dv.pose(), np.zeros((3, 4), np.float32)]))
    stream.describe(["a"])
    stream.publish(0, fire3dv.pose((1, 2, 3)))
    stream.publish(0, np.eye(4))
    assert [str(w.message).split(":")[0] for w in caught] == ["all numbers of the rotation are 0 for 'b'"], caught
    assert caught[0].filename == __file__
print("ok")
