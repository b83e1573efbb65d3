"""Glass ball, environment image: written by the program gallery_scenes."""
import environments
from reference_scene import Scene, from_gallery

SCENE = Scene("Glass ball, environment image", from_gallery(), size=(48, 36), bounces=16, samples=256, cycles_samples=8192,
              environment=environments.studio)
