"""Two blended sheets that cross: each veils half of the other."""
import numpy as np
from gltf import Gltf, sheet
from reference_scene import Scene, from_gltf


def make():
    gltf = Gltf()
    for color, angle in (((0.9, 0.3, 0.1), 45), ((0.2, 0.3, 0.9), -45)):
        half = np.radians(angle) / 2
        material = gltf.material((0, 0, 0), alpha=0.6, emissiveFactor=list(color), doubleSided=True,
                                 extensions={"specular": {"specularFactor": 0}})
        gltf.mesh(sheet(0.6, 0.6), material, rotation=[0, 0, float(np.sin(half)), float(np.cos(half))])
    gltf.camera((0.3, 1.6, 2), (0, 0, 0), 38)
    return gltf


SCENE = Scene("Two blended sheets that cross", from_gltf(make), samples=64, cycles_samples=1024)
