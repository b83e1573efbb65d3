"""Renders one glTF scene with Blender's Cycles; runs inside of Blender 3.4 (Debian 12), which has no other use here.

    blender -b --factory-startup -noaudio -P cycles_reference.py -- SCENE.glb OUT.npy --size 64x48 --spp 1024 --bounces 0
        [--seed 1] [--environment FILE.exr] [--background 000000]

OUT.npy has linear radiance in the units of the file (1 cd: 1 W/sr; 1 lx: 1 W/m2), float32, rows from the top. The
defaults of Blender that are biased or differ from glTF are changed; docs/truth.md lists what remains different.
"""
import argparse
import json
import math
import os
import struct
import sys
import tempfile

import bpy
import numpy as np

# The importer of Blender 3.4 uses names that NumPy 1.24 removed.
np.bool, np.int, np.float, np.object = bool, int, float, object


def arguments():
    parser = argparse.ArgumentParser(prog="cycles_reference.py")
    parser.add_argument("scene")
    parser.add_argument("out")
    parser.add_argument("--size", default="64x48")
    parser.add_argument("--spp", type=int, default=1024)
    parser.add_argument("--bounces", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--environment", default="")
    parser.add_argument("--background", choices=("environment", "000000"), default="environment")
    parser.add_argument("--camera", default="")
    parser.add_argument("--facets", choices=("one-bounce", "all-bounces"), default="all-bounces")
    return parser.parse_args(sys.argv[sys.argv.index("--") + 1:])


def gltf_materials(path):
    """The materials of a .glb file by name, as glTF has them: the importer drops specularFactor 0."""
    with open(path, "rb") as file:
        length, = struct.unpack("<12xI4x", file.read(20))
        document = json.loads(file.read(length))
    known = {}
    for material in document.get("materials", []):
        name = material.get("name", "")
        if known.setdefault(name, material) != material:
            sys.exit(f"cycles_reference.py: {path}: two different materials are called \"{name}\"; rename one")
    return known


def replace_surface(material, node_type, color, roughness, distribution, emission, alpha):
    tree = material.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    surface = tree.nodes.new(node_type)
    surface.inputs["Color"].default_value = (*color, 1)
    surface.inputs["Roughness"].default_value = roughness
    if distribution is not None:
        surface.distribution = distribution
    shader = surface.outputs["BSDF"]
    if any(emission):
        light, total = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeAddShader")
        light.inputs["Color"].default_value = (*emission, 1)
        tree.links.new(shader, total.inputs[0])
        tree.links.new(light.outputs[0], total.inputs[1])
        shader = total.outputs[0]
    if alpha < 1:
        clear, mixed = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeMixShader")
        mixed.inputs["Fac"].default_value = alpha
        tree.links.new(clear.outputs[0], mixed.inputs[1])
        tree.links.new(shader, mixed.inputs[2])
        shader = mixed.outputs[0]
    tree.links.new(shader, output.inputs["Surface"])


def set_materials(path, facets):
    distribution = "GGX" if facets == "one-bounce" else "MULTI_GGX"
    known = gltf_materials(path)
    for material in bpy.data.materials:
        gltf = known.get(material.name.split(".")[0], {})
        base = gltf.get("pbrMetallicRoughness", {})
        metallic, roughness = base.get("metallicFactor", 1), base.get("roughnessFactor", 1)
        *color, alpha = base.get("baseColorFactor", [1, 1, 1, 1])
        rest = gltf.get("emissiveFactor", [0, 0, 0]), alpha if gltf.get("alphaMode") == "BLEND" else 1
        specular = gltf.get("extensions", {}).get("KHR_materials_specular", {}).get("specularFactor", 1)
        if metallic == 0 and specular == 0:  # the Principled node has Burley's diffuse lobe, and keeps its highlight
            replace_surface(material, "ShaderNodeBsdfDiffuse", color, 0, None, *rest)
        elif metallic == 1 and min(color) == 1:  # without the Fresnel term of the Principled node
            replace_surface(material, "ShaderNodeBsdfGlossy", color, roughness, distribution, *rest)
        for node in material.node_tree.nodes if material.use_nodes else ():
            if node.type == "BSDF_PRINCIPLED":
                node.distribution = distribution


def set_environment(scene, path):
    scene.world = bpy.data.worlds.new("environment")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = 1 if path else 0
    if not path:
        return
    image = tree.nodes.new("ShaderNodeTexEnvironment")
    image.image = bpy.data.images.load(path)
    image.image.colorspace_settings.name = "Linear"
    turn = tree.nodes.new("ShaderNodeMapping")
    turn.inputs["Rotation"].default_value = (0, 0, -math.pi / 2)  # --environment-rotation 0
    place = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(place.outputs["Generated"], turn.inputs["Vector"])
    tree.links.new(turn.outputs["Vector"], image.inputs["Vector"])
    tree.links.new(image.outputs["Color"], background.inputs["Color"])


def set_renderer(scene, options, width, height):
    scene.render.engine = "CYCLES"
    scene.camera = next(o for o in scene.objects if o.type == "CAMERA" and options.camera in ("", o.name))
    render, cycles = scene.render, scene.cycles
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.dither_intensity = 0
    render.film_transparent = options.background == "000000"
    cycles.samples, cycles.seed = options.spp, options.seed
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = cycles.light_sampling_threshold = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = options.bounces
    cycles.transmission_bounces = cycles.volume_bounces = options.bounces
    cycles.transparent_max_bounces = max(8, options.bounces)
    for light in bpy.data.lights:  # glTF's lamps have no size
        if light.type == "SUN":
            light.angle = 0
        else:
            light.shadow_soft_size = 0


def main():
    options = arguments()
    width, height = map(int, options.size.split("x"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # COMPAT: candela and lux are watts per steradian and per square metre; the default divides by 683.
    bpy.ops.import_scene.gltf(filepath=options.scene, convert_lighting_mode="COMPAT")
    scene = bpy.context.scene
    set_renderer(scene, options, width, height)
    set_environment(scene, options.environment)
    set_materials(options.scene, options.facets)
    with tempfile.TemporaryDirectory() as folder:
        settings = scene.render.image_settings
        settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
        scene.render.filepath = os.path.join(folder, "image.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Linear"
        pixels = np.array(image.pixels[:], np.float32).reshape(height, width, -1)
    np.save(options.out, pixels[::-1, :, :3])


main()
