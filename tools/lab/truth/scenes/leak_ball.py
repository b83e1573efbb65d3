"""Inside of a closed, coarse, smooth-shaded ball with the sun outside: no light."""
import numpy as np
from gltf import Gltf, ball
from reference_scene import Scene, from_gltf


def make():
    gltf = Gltf()
    gltf.mesh(ball(1, 12, 6), gltf.matte(doubleSided=True))
    gltf.light("directional", 3, (3, 2, 1))
    gltf.camera((0, 0, 0.5), (0, 0, -1), 80)
    return gltf


SCENE = Scene("Inside of a closed ball of 12 x 6 faces, sun outside", from_gltf(make), bounces=8, samples=64, closed_form=0.0,
              level=0.8 / np.pi * 3)
