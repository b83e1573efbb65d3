"""Dark cables of 0.1 to 0.3 pixels before a white sheet."""
import numpy as np
from gltf import Gltf, rod, sheet
from reference_scene import Scene, from_gltf

PIXEL_M = 2 * 3 * np.tan(np.radians(38) / 2) / 72  # at the cables, 3 m away


def make():
    gltf = Gltf()
    white = gltf.material((0, 0, 0), emissiveFactor=[1, 1, 1], extensions={"specular": {"specularFactor": 0}})
    gltf.mesh(sheet(4, 4), white, translation=[0, 0, -0.5], rotation=[0.7071067811865476, 0, 0, 0.7071067811865476])
    black = gltf.matte((0, 0, 0))
    for i, width in enumerate((0.1, 0.15, 0.2, 0.25, 0.3)):
        y = 0.7 - 0.35 * i
        gltf.mesh(rod((-1.5, y, 0), (1.5, y + 0.23, 0), width * PIXEL_M / 2), black)
    gltf.camera((0, 0, 3), (0, 0, 0), 38)
    return gltf


SCENE = Scene("Cables of 0.1 to 0.3 pixels", from_gltf(make), samples=1024)
