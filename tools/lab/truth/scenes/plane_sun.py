"""Matte plane, directional lamp: written by the program gallery_scenes."""
from reference_scene import Scene, from_gallery

SCENE = Scene("Matte plane, directional lamp", from_gallery(), size=(64, 48), samples=16, cycles_samples=64)
