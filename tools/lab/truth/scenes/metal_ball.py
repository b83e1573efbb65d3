"""Metal ball, point lamp: written by the program gallery_scenes."""
from reference_scene import Scene, from_gallery

SCENE = Scene("Metal ball, point lamp", from_gallery(), size=(64, 48), cycles_samples=8192, facets="one-bounce", in_page=False)
