#!/usr/bin/env python3
"""The scene of the needle data set, as one binary glTF file: a suturing needle, its thread and two instruments over
tissue surfaces, of which each sequence shows one."""
import argparse
import concurrent.futures
import functools
import os
import sys

import numpy as np

import shapes
import tissue

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import count, run
from example_mesh import Gltf

#: Semantic classes, as label images and boxes have them.
CLASSES = {"needle": 1, "thread": 2, "instrument": 3, "tissue": 4}
NEEDLE, THREAD, LAMPS = "needle", "thread", ("lamp 1", "lamp 2")
#: Names of the instruments, with the bend of their jaws in metres and the colour of the jaws' inner faces.
INSTRUMENTS = {"driver": (0.0, shapes.GOLD), "forceps": (0.0016, shapes.STEEL)}
PARTS = ("shaft", "wrist", "jaw 1", "jaw 2")
FOV_RAD = np.radians(40)  # vertical


def joints():
    return [f"thread joint {i}" for i in range(shapes.THREAD_JOINTS)]


def parts(instrument):
    """Names of the nodes of an instrument."""
    return [f"{instrument} {part}" for part in PARTS]


def surfaces(number):
    return [f"tissue {i}" for i in range(number)]


def views(number):
    return [f"view {i}" for i in range(number)]


def make_textures(texels, seed):
    return tissue.textures(tissue.Surface(seed), texels)


def add_tissues(gltf, number, texels, cells):
    seeds = range(1, number + 1)
    with concurrent.futures.ProcessPoolExecutor() as pool:
        made = list(pool.map(functools.partial(make_textures, texels), seeds))
    for name, seed, files in zip(surfaces(number), seeds, made):
        color, rough, normal = (gltf.texture(png) for png in files)
        wet = gltf.material(1.0, clearcoat=0.35, baseColorTexture=color, metallicRoughnessTexture=rough, normalTexture=normal)
        gltf.node(name, tissue.mesh(tissue.Surface(seed), cells), wet, CLASSES["tissue"])


def add_thread(gltf, material):
    """A skin whose joints are nodes of the scene: a recording moves them."""
    first = len(gltf.document["nodes"])
    inverse = np.tile(np.eye(4), (shapes.THREAD_JOINTS, 1, 1))
    inverse[:, 0, 3] = -shapes.THREAD_SEGMENT_M * np.arange(shapes.THREAD_JOINTS)
    for i, name in enumerate(joints()):
        gltf.node(name, translation=[shapes.THREAD_SEGMENT_M * i, 0, 0])
    columns = gltf.accessor(inverse.transpose(0, 2, 1), "<f4", "MAT4")
    gltf.document["skins"] = [{"joints": list(range(first, first + shapes.THREAD_JOINTS)), "inverseBindMatrices": columns}]
    gltf.node(THREAD, shapes.thread(), material, CLASSES["thread"], skin=0)


def write_scene(path, tissue_count, view_count, texels, cells):
    gltf = Gltf()
    steel, composite, fibre = gltf.material(0.27, metallic=0.95), gltf.material(0.42), gltf.material(0.55)
    gltf.node(NEEDLE, shapes.needle(), gltf.material(0.22, metallic=0.95), CLASSES["needle"], extras={"keypoints": shapes.KEYPOINTS})
    for name, (bend, insert) in INSTRUMENTS.items():
        sleeve, collar = shapes.shaft()
        meshes = [(sleeve, composite), (collar, steel)], [(shapes.wrist(), steel)], *([(shapes.jaw(side, bend, insert), steel)] for side in (1, -1))
        for part, made in zip(parts(name), meshes):
            gltf.node(part, made, None, CLASSES["instrument"])
    add_thread(gltf, fibre)
    add_tissues(gltf, tissue_count, texels, cells)
    gltf.document["cameras"] = [{"type": "perspective", "perspective": {"yfov": FOV_RAD, "znear": 0.002}}]
    for i, name in enumerate(views(view_count)):
        gltf.node(name, camera=0, translation=[0.02 * i, 0.07, 0.05], rotation=[-0.42, 0, 0, 0.9075])
    for name in LAMPS:
        gltf.node(name)
    gltf.write(path)


def write_environment(path):
    """What metal mirrors in a body cavity, as a Radiance file: wet tissue all around, brighter above, where lamps shine on it."""
    up, around = np.meshgrid(np.linspace(1, -1, 32), np.linspace(-np.pi, np.pi, 64), indexing="ij")
    light = 0.10 + 0.55 * np.exp(-((up - 0.75) / 0.22) ** 2) * (1 + 0.6 * np.sin(3 * around)) + 0.25 * np.clip(-up, 0, 1)
    white = np.clip((up - 0.2) / 0.6, 0, 1)[..., None]
    color = light[..., None] * ((1 - white) * [1.0, 0.42, 0.36] + white * [1.0, 0.90, 0.84])
    mantissa, exponent = np.frexp(color.max(2))
    bytes_of = np.dstack([np.floor(color * (mantissa * 256 / color.max(2))[..., None]), exponent + 128]).astype(np.uint8)
    with open(path, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n" + bytes_of.tobytes())


def add_options(parser):
    parser.add_argument("--tissues", type=count, default=8, help="number of tissue surfaces (default: %(default)s)")
    parser.add_argument("--views", type=count, default=5, help="number of cameras (default: %(default)s)")


def main():
    parser = argparse.ArgumentParser(description=__doc__.replace("\n", " "))
    parser.add_argument("out", metavar="SCENE.glb", help="file to write")
    parser.add_argument("--environment", metavar="FILE.hdr", help="also writes what the metal mirrors")
    add_options(parser)
    parser.add_argument("--texels", type=count, default=1024, help="side of the tissues' textures (default: %(default)s)")
    parser.add_argument("--cells", type=count, default=192, help="side of the tissues' grids (default: %(default)s)")
    options = parser.parse_args()
    write_scene(options.out, options.tissues, options.views, options.texels, options.cells)
    if options.environment:
        write_environment(options.environment)


if __name__ == "__main__":
    run(main)
