"""Post and metal box on ground under an environment image with a small sun, without lamps."""
import environments
from gltf import Gltf, box, sheet
from reference_scene import Scene, from_gltf


def make():
    gltf = Gltf()
    gltf.mesh(sheet(4, 4), gltf.matte((0.6, 0.6, 0.6)))
    gltf.mesh(box(0.3, 1.0, 0.3), gltf.matte((0.8, 0.3, 0.2)), translation=[-0.5, 0.5, 0])
    gltf.mesh(box(0.5, 0.4, 0.5), gltf.material((0.9, 0.8, 0.6), metallic=1, roughness=0.5), translation=[0.5, 0.2, 0.2])
    gltf.camera((0.3, 1.7, 3.2), (0, 0.35, 0), 38)
    return gltf


SCENE = Scene("Sky with a sun", from_gltf(make), bounces=4, samples=256, cycles_samples=4096, environment=environments.sunny,
              background="000000")
