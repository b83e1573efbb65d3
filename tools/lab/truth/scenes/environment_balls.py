"""Matte and metal ball, environment image: written by the program gallery_scenes."""
import environments
from reference_scene import Scene, from_gallery

SCENE = Scene("Matte and metal ball, environment image", from_gallery(), size=(48, 32), bounces=8, cycles_samples=16384,
              environment=environments.studio)
