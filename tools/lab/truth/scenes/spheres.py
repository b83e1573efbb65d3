"""Metal and matte balls on ground, environment image: written by the program gallery_scenes."""
import environments
from reference_scene import Scene, from_gallery

SCENE = Scene("Metal and matte balls on ground, environment image", from_gallery(), bounces=8, cycles_samples=4096,
              environment=environments.studio)
