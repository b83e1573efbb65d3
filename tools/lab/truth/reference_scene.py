"""A reference scene: what its file in scenes/ declares as SCENE. The file's name is the scene's name."""
import dataclasses
import os
import subprocess
from typing import Callable, Optional, Union

import numpy as np


def from_gallery():
    """write() of a scene of the program gallery_scenes, which writes all of its scenes."""
    def write(bin_folder, path):
        if not os.path.exists(path):
            subprocess.run([os.path.join(bin_folder, "gallery_scenes"), os.path.dirname(path)], check=True, stdout=subprocess.DEVNULL)
    return write


def from_gltf(make):
    """write() of a function that returns a gltf.Gltf."""
    return lambda bin_folder, path: make().write(path)


@dataclasses.dataclass
class Scene:
    """write: called with the folder of the programs and the path of the .glb file.

    Reference, the first that is there: closed_form, radiance of the whole image or of each pixel; the stored Cycles
    image, of cycles_samples a pixel; the path tracer.
    """
    title: str
    write: Callable
    size: tuple = (96, 72)  # pixels: columns, rows
    bounces: int = 0
    samples: int = 128  # of a pixel, path tracer
    closed_form: Optional[Union[float, Callable[[], np.ndarray]]] = None
    mask: Optional[Callable[[], np.ndarray]] = None  # pixels that are compared; all without it
    cycles_samples: int = 0
    environment: Optional[Callable[[], np.ndarray]] = None  # environments.py
    background: str = ""  # of --background; empty: the environment, or black without one
    level: float = 0  # radiance to which errors are relative; 0: the reference's mean
    facets: str = "all-bounces"  # of metals in Cycles
    arguments: tuple = ()  # further options of fire3dv
    in_page: bool = True  # false: only a Cycles image for a test
