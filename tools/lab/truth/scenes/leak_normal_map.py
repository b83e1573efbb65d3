"""Sheet with a normal map that tilts by 40 degrees towards a lamp below the sheet: no light."""
import numpy as np
from gltf import Gltf, sheet
from reference_scene import Scene, from_gltf


def make():
    gltf = Gltf()
    tilt = np.radians(40)
    normal = np.array([np.sin(tilt), 0, np.cos(tilt)])
    texture = gltf.texture(np.tile(np.rint(127.5 * normal + 127.5), (4, 4, 1)))
    gltf.mesh(sheet(), gltf.matte(normalTexture={"index": texture}))
    elevation = np.radians(-15)
    gltf.light("directional", 1, (np.cos(elevation), np.sin(elevation), 0))
    gltf.camera((0, 2.5, 0.01), (0, 0, 0), 40)
    return gltf


SCENE = Scene("Sheet, normal map tilted to a lamp below", from_gltf(make), samples=32, closed_form=0.0, level=0.8 / np.pi)
