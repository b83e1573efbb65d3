#!/usr/bin/env python3
"""Program test of bullet_arm: hashes, exit codes, and the scene file, read by an independent parser.

bullet_arm_program_test.py PROGRAM SCENE_TO_WRITE
"""
import json
import math
import os
import resource
import signal
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import threading

program, scene_path = sys.argv[1:3]
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def run(*arguments):
    return subprocess.run([program, *arguments], capture_output=True, text=True, timeout=300)


def expect(condition, text):
    if not condition:
        sys.exit(f"bullet_arm_program_test: {text}")


def check_hashes():
    def printed(*arguments):
        result = run("--hash", "--frames", "300", *arguments)
        expect(result.returncode == 0 and "frames 300 hash " in result.stdout, f"no hash: {result}")
        return result.stdout

    expect(printed() == printed(), "two runs of one seed differ")
    expect(printed() != printed("--seed", "8"), "another seed gives the same poses")


def check_exit_codes():
    for arguments in ([], ["--to"], ["--rate", "0", "--hash"], ["--no-such-option"], ["--lockstep", "--hash"], ["--show-contacts", "--hash"], ["--joint-scalars", "--hash"],
                      ["--realtime", "--fast", "--hash"], ["--frames", "-3", "--hash"]):
        result = run(*arguments)
        expect(result.returncode == 2 and result.stderr.strip(), f"{arguments}: not a usage error: {result}")
    expect(run("--help").returncode == 0, "--help fails")
    for arguments in (["--to", "carrier-pigeon://demo"], ["--write-scene", "/nowhere/at/all.glb"]):
        result = run(*arguments)
        expect(result.returncode == 1 and len(result.stderr.splitlines()) == 1, f"{arguments}: {result}")


def read_glb(path):
    data = open(path, "rb").read()
    magic, version, length = struct.unpack_from("<4sII", data)
    expect(magic == b"glTF" and version == 2 and length == len(data), "the file header is wrong")
    json_length, json_type = struct.unpack_from("<I4s", data, 12)
    expect(json_type == b"JSON" and json_length % 4 == 0, "the first chunk is not JSON")
    document = json.loads(data[20:20 + json_length])
    bin_length, bin_type = struct.unpack_from("<I4s", data, 20 + json_length)
    binary = data[28 + json_length:]
    expect(bin_type == b"BIN\0" and bin_length == len(binary), "the second chunk is not the buffer")
    expect(document["buffers"] == [{"byteLength": len(binary)}], "the buffer's length is wrong")
    return document, binary


def check_geometry(document, binary):
    def values(index):
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        width = COMPONENTS[accessor["type"]]
        count = accessor["count"] * width
        expect(count * 4 == view["byteLength"] and view["byteOffset"] % 4 == 0, f"accessor {index} does not fit")
        letter = {5126: "f", 5125: "I"}[accessor["componentType"]]
        flat = struct.unpack_from(f"<{count}{letter}", binary, view["byteOffset"])
        return [flat[i:i + width] for i in range(0, count, width)]

    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            positions, normals, tangents, uvs = (
                values(primitive["attributes"][name]) for name in ("POSITION", "NORMAL", "TANGENT", "TEXCOORD_0"))
            indices = [i for (i,) in values(primitive["indices"])]
            expect(len(positions) == len(normals) == len(tangents) == len(uvs), f"{mesh['name']}: counts differ")
            expect(len(indices) % 3 == 0 and max(indices) < len(positions), f"{mesh['name']}: bad indices")
            bounds = document["accessors"][primitive["attributes"]["POSITION"]]
            for axis in range(3):
                column = [p[axis] for p in positions]
                expect(min(column) == struct.unpack("f", struct.pack("f", bounds["min"][axis]))[0]
                       and max(column) == struct.unpack("f", struct.pack("f", bounds["max"][axis]))[0],
                       f"{mesh['name']}: bounds are wrong")
            for n, t in zip(normals, tangents):
                dot = sum(a * b for a, b in zip(n, t))
                expect(abs(math.hypot(*n) - 1) < 1e-4 and abs(math.hypot(*t[:3]) - 1) < 1e-4 and abs(dot) < 1e-3
                       and abs(t[3]) == 1, f"{mesh['name']}: normal {n} and tangent {t} are no frame")
            for a, b, c in zip(*[iter(indices)] * 3):
                u = [y - x for x, y in zip(positions[a], positions[b])]
                v = [y - x for x, y in zip(positions[a], positions[c])]
                face = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
                expect(sum(f * n for f, n in zip(face, normals[a])) > 0, f"{mesh['name']}: a triangle faces inwards")


def check_scene():
    result = run("--write-scene", scene_path)
    expect(result.returncode == 0, f"no scene: {result}")
    document, binary = read_glb(scene_path)
    check_geometry(document, binary)
    names = [node["name"] for node in document["nodes"]]
    expect(len(set(names)) == len(names), "node names are not unique")
    for name in ("arm_base", "arm_link_5", "finger_left", "finger_right", "box_000", "domino_00", "floor"):
        expect(name in names, f"no node {name}")
    cameras = [node["name"] for node in document["nodes"] if "camera" in node]
    expect({"camera_front", "camera_gripper"} <= set(cameras), f"cameras are {cameras}")
    lights = document["extensions"]["KHR_lights_punctual"]["lights"]
    expect(len(lights) == 2 and {light["type"] for light in lights} == {"spot", "directional"}, "not two lights")
    for image in document["images"]:
        view = document["bufferViews"][image["bufferView"]]
        start = view["byteOffset"]
        expect(binary[start:start + 8] == b"\x89PNG\r\n\x1a\n", f"{image['name']} is no PNG")
    expect(any("normalTexture" in material for material in document["materials"]), "no normal map")


def check_full_disk():
    """A scene that the disk does not take leaves neither a cut file nor the loss of an earlier one."""
    def limited():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # the write fails, as on a full disk
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "arm.glb")
        for earlier in (None, "an earlier file"):
            if earlier:
                with open(path, "w", encoding="ascii") as file:
                    file.write(earlier)
            result = subprocess.run([program, "--write-scene", path], capture_output=True, text=True, timeout=300, preexec_fn=limited)
            expect(result.returncode == 1 and "cannot write all of" in result.stderr, f"{result}")
            expect(os.listdir(folder) == (["arm.glb"] if earlier else []), f"it left {os.listdir(folder)}")
        with open(path, encoding="ascii") as file:
            expect(file.read() == earlier, "the earlier file has changed")


def check_certificate_verdict():
    """A certificate that bullet_arm does not trust is its own verdict, not a message of the renderer."""
    with tempfile.TemporaryDirectory() as folder, socket.create_server(("127.0.0.1", 0)) as listener:
        key, certificate = os.path.join(folder, "key.pem"), os.path.join(folder, "certificate.pem")
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-keyout",
                        key, "-out", certificate, "-days", "2", "-subj", "/CN=stranger", "-addext",
                        "subjectAltName=IP:127.0.0.1"], check=True, capture_output=True)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate, key)

        def serve():
            try:
                while True:
                    connection, _ = listener.accept()
                    try:
                        context.wrap_socket(connection, server_side=True).close()
                    except OSError:
                        connection.close()
            except OSError:
                pass  # the listener is closed

        threading.Thread(target=serve, daemon=True).start()
        result = run("--to", f"tls://127.0.0.1:{listener.getsockname()[1]}", "--realtime", "--seconds", "3")
        expect("not connected: the peer's certificate is not trusted" in result.stderr, f"no verdict: {result}")
        expect("the renderer says" not in result.stderr, f"the verdict of the renderer: {result}")
        listener.shutdown(socket.SHUT_RDWR)


check_hashes()
check_exit_codes()
check_scene()
check_full_disk()
check_certificate_verdict()
