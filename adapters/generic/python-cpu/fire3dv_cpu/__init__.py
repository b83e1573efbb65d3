"""Mesa's software Vulkan driver (lavapipe) for FIRE-3DV on machines without a GPU.

The programs of the package fire3dv find it by themselves and use it where no GPU can draw. Other programs never see it.
"""
import os

__version__ = "0.2.0"
DRIVER_FILE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "lib", "lvp_icd.json")
