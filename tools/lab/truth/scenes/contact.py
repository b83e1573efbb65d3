"""Box and ball that stand on ground, lit by a low sun and a point lamp: contact shadows."""
from gltf import Gltf, ball, box, sheet
from reference_scene import Scene, from_gltf


def make():
    gltf = Gltf()
    gltf.mesh(sheet(3, 3), gltf.matte((0.6, 0.6, 0.6)))
    gltf.mesh(box(0.4, 0.3, 0.4), gltf.matte((0.8, 0.3, 0.2)), translation=[-0.4, 0.15, 0])
    gltf.mesh(ball(0.25, 96, 48), gltf.matte((0.2, 0.4, 0.8)), translation=[0.4, 0.25, 0.1])
    gltf.light("directional", 2, (2, 1, 1))
    gltf.light("point", 2, (-1, 1.2, 1))
    gltf.camera((0, 1.2, 2.2), (0, 0.15, 0), 38)
    return gltf


SCENE = Scene("Contact shadows", from_gltf(make), samples=64, cycles_samples=1024)
