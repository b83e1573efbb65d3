"""Robot arm of the program bullet_arm."""
import os
import subprocess

import environments
from reference_scene import Scene


def write(bin_folder, path):
    subprocess.run([os.path.join(bin_folder, "bullet_arm"), "--write-scene", path], check=True, stdout=subprocess.DEVNULL)


SCENE = Scene("Robot arm, environment image", write, bounces=8, environment=environments.studio)
