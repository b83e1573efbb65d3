"""Closed room, point lamp: written by the program gallery_scenes."""
from reference_scene import Scene, from_gallery

SCENE = Scene("Closed room, point lamp", from_gallery(), size=(32, 24), bounces=64, samples=256, cycles_samples=32768)
