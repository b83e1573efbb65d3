#!/usr/bin/env python3
"""End-to-end test of usage errors: one line names the object and the remedy; exit code 1 (2 for usage)."""
import os
import random
import re
import socket
import struct
import subprocess

from harness import HANG_S, main, vulkan_environment
from image_reader import check


def run(test, *arguments, env=None):
    """Runs fire3dv with exactly these arguments (no test defaults, which would hide the tested behaviour)."""
    result = subprocess.run([test.programs_at["fire3dv"], *arguments], capture_output=True, text=True, timeout=HANG_S,
                            env=env or vulkan_environment(), check=False)
    return result


def expect_failure(test, code, words, *arguments, env=None, listing=False):
    """Expects failure. listing: indented lines of choices may follow the sentence."""
    result = run(test, *arguments, env=env)
    what = f"fire3dv {' '.join(arguments)}"
    check(result.returncode == code, f"{what}: exit code {result.returncode}, not {code}:\n{result.stderr}")
    lines = result.stderr.splitlines()
    check(all(re.match("fire3dv( [a-z]+)?: (info|warning|error): ", line) or listing and line.startswith("  ")
              for line in lines), f"{what}: not all lines are log lines of fire3dv:\n{result.stderr}")
    faults = [line for line in lines if re.match("fire3dv( [a-z]+)?: error: ", line)]
    check(len(faults) == 1, f"{what}: {len(faults)} lines of fault, not 1:\n{result.stderr}")
    text = faults[0] + "".join(line for line in lines if line.startswith("  "))
    missing = [word for word in words if word not in text]
    check(not missing, f"{what}: lacks {missing}:\n{result.stderr}")
    check(result.stdout == "", f"{what}: wrote to stdout:\n{result.stdout}")


def usage(test):
    scene = test.scene
    for words, arguments in (
            (["name a scene", "fire3dv SCENE.glb", "--help"], []),
            (["--size", "160", "1280x720"], [scene, "--size", "160"]),
            (["--size", "0x90", "1 to 16384"], [scene, "--size", "0x90"]),
            (["--size", "99999x9", "1 to 16384"], [scene, "--size", "99999x9"]),
            (["--size", "160x90x3"], [scene, "--size", "160x90x3"]),
            (["--size", "-1x90"], [scene, "--size=-1x90"]),
            (["--nonsense", "--help"], [scene, "--nonsense"]),
            (['unexpected argument "other.glb"', "quotes"], [scene, "other.glb"]),
            (["--screenshot-size", "big", "7680x4320"], [scene, "--screenshot-size", "big"]),
            (["--screenshot-size", "65536", "256 Mi"], [scene, "--screenshot-size", "65536x65536"]),
            (["--theme", "pink"], [scene, "--theme", "pink"]),
            (["no.conf", "--config none"], [scene, "--config", "no.conf"]),
            (["--frames", "many"], [scene, "--frames", "many"]),
            (["--frames", "-3"], [scene, "--frames=-3"]),
            (["--frames"], [scene, "--headless", "--frames", "0"]),
            (["--samples", "0"], [scene, "--samples", "0"]),
            (["--allow-origin", "no path", "https://sim.example"],
             [scene, "--serve", "127.0.0.1:0", "--allow-origin", "https://sim.example/sim1"]),
            (["--allow-host", "sim.example"], [scene, "--serve", "127.0.0.1:0", "--allow-host", "*"]),
            (["--allow-host", "--serve HOST:PORT"], [scene, "--allow-host", "sim.example"]),
            (["--exposure"], [scene, "--exposure", "-1"]),
            (["--exposure"], [scene, "--exposure", "nan"]),
            (["--shadows", "maybe"], [scene, "--shadows", "maybe"]),
            (["--raster", "maybe"], [scene, "--raster", "maybe"]),
            (["--shadow-rays", "maybe"], [scene, "--shadow-rays", "maybe"]),
            (["--lod", "maybe"], [scene, "--lod", "maybe"]),
            (["--cull", "maybe"], [scene, "--cull", "maybe"]),
            (["--async-compute", "maybe"], [scene, "--async-compute", "maybe"]),
            (["--anisotropy", "nan"], [scene, "--anisotropy", "nan"]),
            (["--anisotropy", "17"], [scene, "--anisotropy", "17"]),
            (["--bloom", "nan", "0 to 1"], [scene, "--bloom", "nan"]),
            (["--bloom", "1.5", "0 to 1"], [scene, "--bloom", "1.5"]),
            (["--ray-effects mirrors", "reflections, ao"], [scene, "--ray-effects", "mirrors"]),
            (["--f-number", "0", "0.1 to 1000"], [scene, "--f-number", "0"]),
            (["--focus-distance", "inf", "0.001 to 1000000"], [scene, "--focus-distance", "inf"]),
            (["--f-number", "--raster forward"],
             [scene, "--raster", "forward", "--f-number", "2.8", "--focus-distance", "1"]),
            (["--f-number", "--focus-distance", "both"],
             [scene, "--headless", "--frames", "1", "--out", "nowhere", "--f-number", "2.8"]),
            (["--tone-map", "sepia"], [scene, "--tone-map", "sepia"]),
            (["--exposure", "bright", "auto", "metered"], [scene, "--exposure", "bright"]),
            (["--ground", "below", "auto"], [scene, "--ground", "below"]),
            (["--key-light", "maybe"], [scene, "--key-light", "maybe"]),
            (["--background", "blue", "environment"], [scene, "--background", "blue"]),
            (["--background", "#12345", "environment"], [scene, "--background", "#12345"]),
            (["--background", "-12345", "environment"], [scene, "--background=-12345"]),
            (["--environment-rotation", "inf"], [scene, "--environment-rotation", "inf"]),
            (["--environment-intensity", "-1"], [scene, "--environment-intensity=-1"]),
            (["--lockstep", "--listen"], [scene, "--lockstep"]),
            (["--wait-for-stream", "--listen"], [scene, "--headless", "--wait-for-stream"]),
            (["--wait-for-stream", "soon"], [scene, "--headless", "--listen", "shm://none", "--wait-for-stream", "soon"]),
            (["--exit-when-done", "--listen"], [scene, "--exit-when-done"]),
            (["--frames", "--on-request"], [scene, "--headless", "--listen", "shm://none", "--on-request", "--frames", "3"]),
            (["second.glb"], [scene, "second.glb"]),
            (["--headless", "--out DIR", "--listen URI"], [scene, "--headless"]),
            (["unknown option --lisen", "did you mean --listen?"], [scene, "--headless", "--lisen", "shm://none"]),
            (["--camera"], [scene, "--camera"])):
        expect_failure(test, 2, words, *arguments)
    for asked in ("--help", "--version"):
        result = run(test, asked)
        check(result.returncode == 0 and result.stderr == "" and result.stdout, f"{asked}: {result}")


def headless(test, *arguments):
    return ["--headless", "--validation", "--size", "64x36", "--frames", "2", *arguments]


def scenes(test):
    def file_of(name, data):
        path = test.path(name)
        with open(path, "wb") as file:
            file.write(data)
        return path

    with open(test.scene, "rb") as file:
        good = file.read()
    lying = bytearray(good)
    struct.pack_into("<I", lying, 12, 0xfffffff0)  # length of the first chunk
    noise = random.Random(1)
    for name, path in (
            ("missing", test.path("no_such_scene.glb")),
            ("a folder", test.folder),
            ("empty", file_of("empty.glb", b"")),
            ("garbage", file_of("garbage.glb", noise.randbytes(5000))),
            ("garbage text", file_of("garbage.gltf", noise.randbytes(5000))),
            ("header only", file_of("header.glb", good[:12])),
            ("cut in the JSON", file_of("cut_json.glb", good[:200])),
            ("cut in the buffer", file_of("cut_buffer.glb", good[:-20])),
            ("lying length", file_of("lying.glb", bytes(lying))),
            ("not JSON", file_of("not_json.gltf", b"{\"asset\": ")),
            ("JSON but no glTF", file_of("list.gltf", b"[1, 2, 3]")),
            ("unknown kind", file_of("scene.step", b"ISO-10303-21;\n")),
            ("mesh without triangles", file_of("scene.obj", b"v 0 0 0\n")),
            ("USD", file_of("scene.usda", b"#usda 1.0\n")),
            ("missing buffer", file_of("far.gltf", b'{"asset":{"version":"2.0"},"buffers":[{"byteLength":9,"uri":"gone.bin"}],'
                                       b'"nodes":[{}],"scenes":[{"nodes":[0]}],"scene":0}')),
            ("outside path", file_of("out.gltf", b'{"asset":{"version":"2.0"},"buffers":[{"byteLength":9,"uri":"../../etc/passwd"}],'
                                     b'"nodes":[{}],"scenes":[{"nodes":[0]}],"scene":0}'))):
        expect_failure(test, 1, [os.path.basename(path)], path, *headless(test))
    expect_failure(test, 1, ["no_such_scene.glb", "No such file"], test.path("no_such_scene.glb"), *headless(test))
    expect_failure(test, 1, ["scene.step", "a STEP model", "glTF"], test.path("scene.step"), *headless(test))
    # The file is reported even where no window can be opened.
    env = {name: value for name, value in vulkan_environment().items()
           if name not in ("DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR")}
    expect_failure(test, 1, ["no_such_scene.glb", "No such file"], test.path("no_such_scene.glb"), env=env)
    expect_failure(test, 1, ["gone.urdf", "No such file"], test.path("gone.urdf"), env=env)


def environments(test):
    def refused(words, path):
        expect_failure(test, 1, ["--environment", *words], test.scene, "--environment", path, *headless(test))

    refused(["no_such.hdr", "No such file"], test.path("no_such.hdr"))
    refused([os.path.basename(test.folder)], test.folder)
    refused([os.path.basename(test.scene), "neither a Radiance nor an OpenEXR image", ".exr"], test.scene)
    cut = test.path("cut.hdr")
    with open(cut, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n" + bytes([1, 2, 3, 128] * 3))
    refused(["cut.hdr", "row 1", "copy or save"], cut)
    whole = test.path("whole.hdr")
    with open(whole, "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n" + bytes([1, 2, 3, 128] * 4))
    result = run(test, test.scene, "--environment", whole, "--background", "environment", "--environment-rotation", "-90",
                 "--environment-intensity", "0", *headless(test))
    check(result.returncode == 0, f"--environment {whole}: {result.stderr}")


def cameras(test):
    expect_failure(test, 1, ["--camera nobody", "squares.glb", "front"], test.scene, "--camera", "nobody", *headless(test))


def animations(test):
    for argument in ("walk", "0", "all"):
        expect_failure(test, 1, ["--animate", "the scene has no animations"], test.scene, "--animate", argument,
                       *headless(test))


def links(test):
    scene = test.scene
    remedy = ["shm://NAME", "tcp://HOST:PORT", "udp://HOST:PORT"]
    for uri, words in (("carrier-pigeon://loft", ["carrier-pigeon", *remedy]),
                       ("nonsense", ["nonsense", *remedy]),
                       ("shm://", ["shm://", *remedy]),
                       ("shm://../../etc/passwd", ["shm://../../etc/passwd", *remedy]),
                       ("tcp://127.0.0.1", ["tcp://127.0.0.1", "port", *remedy]),
                       ("tcp://127.0.0.1:99999", ["99999", "65535"]),
                       ("udp://:7346", ["udp://:7346", "host"]),
                       ("tcp://192.0.2.1:7345", ["tcp://192.0.2.1:7345", "--insecure"]),
                       ("tcp://0.0.0.0:0", ["tcp://0.0.0.0:0", "--insecure", "127.0.0.1"]),
                       ("udp://0.0.0.0:0", ["udp://0.0.0.0:0", "--insecure", "127.0.0.1"]),
                       ("tcp://no-such-host.invalid:7345", ["no-such-host.invalid"])):
        expect_failure(test, 1, words, scene, "--listen", uri, *headless(test))
    expect_failure(test, 1, ["192.0.2.1"], scene, "--listen", "tcp://192.0.2.1:7345", "--insecure", *headless(test))
    for scheme, kind in (("tcp", socket.SOCK_STREAM), ("udp", socket.SOCK_DGRAM)):
        with socket.socket(socket.AF_INET, kind) as taken:
            taken.bind(("127.0.0.1", 0))
            if kind == socket.SOCK_STREAM:
                taken.listen()
            uri = f"{scheme}://127.0.0.1:{taken.getsockname()[1]}"
            expect_failure(test, 1, [uri, "in use"], scene, "--listen", uri, *headless(test))
    twice = test.fresh_uri("tcp")
    expect_failure(test, 1, [twice, "in use"], scene, "--listen", twice, "--listen", twice, *headless(test))
    result = run(test, scene, "--listen", "udp://0.0.0.0:0", "--insecure", *headless(test))
    check(result.returncode == 0, f"--insecure does not allow it:\n{result.stderr}")


def devices(test):
    expect_failure(test, 1, ["--device voodoo2", "llvmpipe", "software"], test.scene, "--device", "voodoo2",
                   *headless(test), listing=True)
    expect_failure(test, 1, ["--device 7", "llvmpipe"], test.scene, "--device", "7", *headless(test), listing=True)
    nothing = {**vulkan_environment(), "VK_DRIVER_FILES": "/nonexistent", "VK_ICD_FILENAMES": "/nonexistent"}
    driver = ["Vulkan", "driver", "mesa-vulkan-drivers"]
    expect_failure(test, 1, driver, test.scene, *headless(test), env=nothing)
    expect_failure(test, 1, driver, test.scene, "--headless", "--frames", "1", env=nothing)
    expect_failure(test, 1, driver, "--list-devices", env=nothing)
    expect_failure(test, 1, ["VK_DRIVER_FILES", "/nonexistent", "unset"], test.scene, *headless(test), env=nothing)
    only_old = {**nothing}
    del only_old["VK_DRIVER_FILES"]
    expect_failure(test, 1, ["VK_ICD_FILENAMES", "/nonexistent", "unset"], "--list-devices", env=only_old)


def outputs(test):
    in_the_way = test.path("file")
    with open(in_the_way, "w", encoding="utf-8") as file:
        file.write("a file")
    below = os.path.join(in_the_way, "images")
    expect_failure(test, 1, [below, "folder"], test.scene, "--out", below, *headless(test))
    expect_failure(test, 1, [in_the_way, "folder"], test.scene, "--out", in_the_way, *headless(test))
    stats = os.path.join(in_the_way, "stats.csv")
    expect_failure(test, 1, ["--stats", stats, "choose another file"], test.scene, "--stats", stats, *headless(test))
    expect_failure(test, 1, ["--stats", test.folder], test.scene, "--stats", test.folder, *headless(test))
    full = run(test, test.scene, "--stats", "/dev/full", *headless(test))
    check(full.returncode == 1 and "--stats /dev/full" in full.stderr and "full" in full.stderr,
          f"a full disk goes unnoticed:\n{full.stderr}")
    check(open(in_the_way, encoding="utf-8").read() == "a file", "a file that stood in the way was written to")


def displays(test):
    env = {k: v for k, v in vulkan_environment().items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    expect_failure(test, 1, ["window", "--headless"], test.scene, "--frames", "1", env=env)
    expect_failure(test, 1, ["window", "--headless"], test.scene, "--frames", "1", env={**env, "DISPLAY": ":4711"})
    # What else is wrong is said first.
    gone = test.path("gone")
    open_key = test.path("open.key")
    with open(open_key, "w", encoding="ascii") as file:
        file.write("0" * 64)
    os.chmod(open_key, 0o644)
    for words, arguments in (
            (["gone", "No such file"], ["--replay", gone + ".mcap"]),
            (["--out", open_key, "name another folder"], ["--out", open_key]),
            (["--out", open_key, "name another folder"], ["--out", os.path.join(open_key, "images")]),
            (["--stats", gone], ["--stats", os.path.join(gone, "a.csv")]),
            (["--record", gone, "create it"], ["--listen", "shm://a", "--record", os.path.join(gone, "a.mcap")]),
            (["--environment", gone, "No such file"], ["--environment", gone + ".hdr"]),
            (["--key-file", gone], ["--listen", "udp://127.0.0.1:0", "--key-file", gone]),
            (["--key-file", open_key], ["--listen", "udp://127.0.0.1:0", "--key-file", open_key]),
            (["tls://127.0.0.1:0", gone], ["--listen", "tls://127.0.0.1:0", "--tls-cert", gone, "--tls-key", gone]),
            (["--serve 127.0.0.1:0", gone], ["--serve", "127.0.0.1:0", "--tls-cert", gone, "--tls-key", gone]),
            (["--serve-tokens", open_key], ["--serve", "127.0.0.1:0", "--serve-tokens", open_key])):
        expect_failure(test, 1, words, test.scene, *arguments, env=env)


if __name__ == "__main__":
    main({f.__name__: f for f in (usage, scenes, environments, cameras, animations, links, devices, outputs, displays)},
         ["fire3dv"])
