#!/usr/bin/env python3
"""End-to-end test of what smaller devices get: FIRE3DV_DEVICE_MASK hides features and limits of the test driver. A
fallback draws the image of the option that chooses it; a device that cannot draw is refused with what it lacks.
"""
import os

from harness import main, vulkan_environment
from image_reader import check, read_png, write_scene


def image_of(test, *arguments, mask=None, driver=None):
    """Pixels and log of one image with shadows."""
    scene = test.path("lit.glb")
    if not os.path.exists(scene):
        write_scene(scene, sun=True)
    env = {**vulkan_environment(), **({"FIRE3DV_DEVICE_MASK": mask} if mask else {}), **(driver or {})}
    renderer = test.renderer("--frames", "1", *arguments, scene=scene, env=env)
    renderer.expect_exit(0)
    return renderer.picture(renderer.frames()[0]), renderer.stderr_text()


def difference(a, b):
    """Largest difference of a channel."""
    return max(abs(x - y) for row_a, row_b in zip(a.rows, b.rows) for x, y in zip(row_a, row_b))


def falls_back(mask, *options, said, least=0, driver=None):
    def run(test):
        expected, _ = image_of(test, *options)
        got, log = image_of(test, mask=mask, driver=driver)
        check(said in log, f"{mask}: the log lacks {said!r}:\n{log}")
        check(mask is None or f"masked by FIRE3DV_DEVICE_MASK={mask}" in log, log)
        largest = difference(expected, got)
        check(largest <= least, f"{mask}: differs from {options} by {largest}")
    return run


def refused(mask, said, *arguments):
    def run(test):
        renderer = test.renderer("--frames", "1", *arguments, env={**vulkan_environment(), "FIRE3DV_DEVICE_MASK": mask})
        renderer.expect_exit(1)
        check(said in renderer.stderr_text(), f"{mask}: {renderer.stderr_text()}")
    return run


def refusals(test):
    for mask, said in (("no-subgroup-operations", "lacks: subgroup ballot and arithmetic in compute shaders"),
                       ("threads=128", "lacks: workgroups of 256 threads"), ("no-scalar-layout", "lacks: scalarBlockLayout"),
                       ("no-raytracing", "FIRE3DV_DEVICE_MASK: unknown word \"no-raytracing\"; the words are: no-ray-query"),
                       ("samples=", "unknown word \"samples=\""), ("samples=0", "unknown word"),
                       ("samples=3", "\"samples=3\" is no power of two"), ("subgroup=24", "is no power of two")):
        refused(mask, said)(test)


CASES = {
    "no_64_bit_atomics": falls_back("no-int64-atomics", "--raster", "forward", said="forward"),
    "no_ray_query": falls_back("no-ray-query", said="shadow maps and a ray-tracing pipeline", least=1),
    "no_rays": falls_back("no-ray-query,no-ray-pipeline", "--shadows", "map", said="shadows: shadow maps"),
    "one_sample": falls_back("samples=1", "--samples", "1", said="1 sample"),
    "shaders_of_gpus": falls_back("no-software,subgroup=64", said="discrete GPU", least=1),
    "four_lanes": falls_back(None, said="llvmpipe", least=1, driver={"LP_NATIVE_VECTOR_WIDTH": "128"}),
    "few_features": falls_back("no-dual-source,no-sample-shading,no-multisample-storage,no-visible-coverage,"
                               "no-indirect-count,no-anisotropy", said="llvmpipe", least=1),
    "refusals": refusals,
}

if __name__ == "__main__":
    main(CASES, ["fire3dv"])
