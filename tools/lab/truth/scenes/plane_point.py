"""Matte plane, point lamp: written by the program gallery_scenes."""
from reference_scene import Scene, from_gallery

SCENE = Scene("Matte plane, point lamp", from_gallery(), size=(64, 48), samples=64, cycles_samples=1024)
