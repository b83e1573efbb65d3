"""White materials in a white environment: 25 tiles, rows are views at 0, 45, 70, 80 and 85 degrees."""
import environments
import numpy as np
from gltf import Gltf, sheet
from reference_scene import Scene, from_gltf

COLUMNS = (dict(roughness=0.5), dict(roughness=0.3, metallic=1.0),
           dict(roughness=0.5, extensions={"sheen": {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.3}}),
           dict(roughness=0.5, extensions={"clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.1}}),
           dict(roughness=0.3, metallic=1.0, extensions={"anisotropy": {"anisotropyStrength": 0.8}}))
ANGLES_DEG = (0, 45, 70, 80, 85)


def make():
    gltf = Gltf()
    for column, lobes in enumerate(COLUMNS):
        material = gltf.material((1, 1, 1), **lobes)
        for row, angle in enumerate(ANGLES_DEG):
            center = np.array([(column - 2) * 0.4, (2 - row) * 0.3, 0.0])
            view = np.array([0, 0, 40.0]) - center
            turn = np.radians(90) - np.radians(angle) + np.arctan2(view[2], view[1]) - np.radians(90)
            gltf.mesh(sheet(0.15, 0.12), material, translation=center.tolist(), rotation=[float(np.sin(turn / 2)), 0, 0, float(np.cos(turn / 2))])
    gltf.camera((0, 0, 40), (0, 0, 0), 2.2)
    return gltf


SCENE = Scene("White furnace: dielectric, metal, sheen, coat, anisotropy", from_gltf(make), bounces=4, samples=64, closed_form=1.0,
              environment=environments.white)
