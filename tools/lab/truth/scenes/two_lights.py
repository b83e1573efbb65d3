"""Spot and point lamp, metal ball: written by the program gallery_scenes."""
from reference_scene import Scene, from_gallery

SCENE = Scene("Spot and point lamp, metal ball", from_gallery(), bounces=8)
