"""Blended ball in a blended shell, both double-sided, on a lit ground."""
from gltf import Gltf, ball, sheet
from reference_scene import Scene, from_gltf


def make():
    gltf = Gltf()
    gltf.mesh(sheet(2, 2), gltf.matte((0.5, 0.5, 0.5)))
    shell = gltf.matte((0.9, 0.8, 0.1), alpha=0.3, doubleSided=True)
    core = gltf.matte((0.1, 0.1, 0.9), alpha=0.9, doubleSided=True)
    gltf.mesh(ball(0.5, 96, 48), shell, translation=[0, 0.6, 0])
    gltf.mesh(ball(0.25, 96, 48), core, translation=[0, 0.6, 0])
    gltf.light("directional", 3, (0.2, 3, 2))
    gltf.camera((0, 1.4, 2.6), (0, 0.45, 0), 38)
    return gltf


SCENE = Scene("Blended ball in a blended shell", from_gltf(make), cycles_samples=2048)
