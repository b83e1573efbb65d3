"""Ball of 16 x 8 smooth-shaded faces lit from the side, against the round ball that it stands for."""
import numpy as np
from gltf import Gltf, ball
from reference_scene import Scene, from_gltf

EYE_M, FOV_DEG, SIZE = 4.0, 32, (96, 72)
SUN = np.array([3.0, 1.0, 1.0]) / np.sqrt(11)


def make():
    gltf = Gltf()
    gltf.mesh(ball(1, 16, 8), gltf.matte())
    gltf.light("directional", 3, SUN)
    gltf.camera((0, 0, EYE_M), (0, 0, 0), FOV_DEG)
    return gltf


def round_ball():
    """Normals of the unit ball at the pixels' centres, and the distance of their rays from its centre."""
    y, x = np.meshgrid(0.5 - (np.arange(SIZE[1]) + 0.5) / SIZE[1], (np.arange(SIZE[0]) + 0.5) / SIZE[0] - 0.5, indexing="ij")
    half = np.tan(np.radians(FOV_DEG) / 2)
    direction = np.stack([2 * half * x * SIZE[0] / SIZE[1], 2 * half * y, -np.ones_like(x)], axis=-1)
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    along = -direction[..., 2] * EYE_M
    distance = np.sqrt(EYE_M ** 2 - along ** 2)
    t = along - np.sqrt(np.maximum(1 - distance ** 2, 0))
    return np.array([0, 0, EYE_M]) + t[..., None] * direction, distance


def radiance():
    normal, distance = round_ball()
    return np.repeat((0.8 / np.pi * 3 * np.maximum(normal @ SUN, 0) * (distance < 1))[..., None], 3, axis=-1)


SCENE = Scene("Ball of 16 x 8 faces, against a round ball", from_gltf(make), size=SIZE, samples=32, closed_form=radiance,
              mask=lambda: round_ball()[1] < 0.85)
