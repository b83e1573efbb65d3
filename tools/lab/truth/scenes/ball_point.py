"""Matte ball, point lamp: written by the program gallery_scenes."""
from reference_scene import Scene, from_gallery

SCENE = Scene("Matte ball, point lamp", from_gallery(), size=(64, 48), cycles_samples=8192)
