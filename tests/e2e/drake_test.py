#!/usr/bin/env python3
"""End-to-end test of fire3dv-drake: images of scenes as Drake sends them, compared with computed values, and hostile clients."""
import base64
import concurrent.futures
import json
import math
import os
import shutil
import signal
import socket
import struct
import subprocess
import time
import zlib

from drake_client import (BOUNDARY, WHITE, Camera, Scene, Server, check_error, form_body, form_fields, identity, look_at,
                          product)
from harness import HANG_S, main, wait_until
from image_reader import check

GREY = (0.5, 0.5, 0.5)
DEPTH_TOLERANCE_M = 0.001  # of Drake's own test


def floor(half=100.0):
    scene = Scene()
    scene.quad(half, identity(), GREY)
    return scene


def check_floor(depths, camera, pose, range_m, scale=1):
    """Compares with the depth of the plane z = 0 along the camera's axis. Returns the numbers of too near and too far pixels."""
    near = far = 0
    for y in range(camera.height):
        for x in range(camera.width):
            down = -camera.ray(pose, x, y)[2]
            wanted = pose[2][3] / down if down > 0 else math.inf
            got = depths[y][x]
            if any(abs(wanted - limit) < DEPTH_TOLERANCE_M for limit in (*range_m, camera.far)):
                continue  # may round to either side
            if wanted > min(range_m[1], camera.far):
                far += 1
                check(got == (math.inf if scale == 1 else 65535), f"{x},{y}: {got}, but {wanted} is too far")
            elif wanted < range_m[0]:
                near += 1
                check(got == 0, f"{x},{y}: {got}, but {wanted} is too near")
            else:
                check(abs(got / scale - wanted) < DEPTH_TOLERANCE_M, f"{x},{y}: {got}, not {wanted}")
    return near, far


def depth(test):
    """Planar depth of a floor, with a principal point beside the centre, and the ends of the sensor's range."""
    pose, range_m = look_at((0.3, -2, 1.5), (0.1, 1, 0.2)), (2.6, 6.0)
    for arguments, scale in (((), 1), (("--depth", "16u"), 1000)):
        server = Server(test, *arguments)
        camera = Camera(center=(20.25, 30.5))
        near, far = check_floor(server.render(floor(), pose, "depth", camera, depth_range=range_m), camera, pose, range_m, scale)
        check(near > 50 and far > 50, f"{near} pixels too near, {far} too far")
        # The far clipping plane ends the scene before the sensor's range does.
        camera = Camera(far=4.0)
        _, far = check_floor(server.render(floor(), pose, "depth", camera, depth_range=range_m), camera, pose, range_m, scale)
        check(far > 500, f"{far} pixels too far")
        server.signal(signal.SIGTERM)
        server.expect_exit(0)


def label_color(label):
    return (label & 255, label >> 8, 0)


def label_scene(places):
    """Squares of half a metre that face along +Z, one for each label: {label: (x, y, z)}."""
    scene = Scene()
    for label, place in places.items():
        scene.quad(0.5, identity(*place), [c / 255 for c in label_color(label)])
    return scene


def check_labels(image, places, camera, height):
    """The camera looks straight down from (0, 0, height), with +Y up in the image. Each pixel has exactly one colour."""
    pose = identity(0, 0, height)
    for y in range(camera.height):
        for x in range(camera.width):
            ray, wanted, nearest = camera.ray(pose, x, y), WHITE, math.inf
            for label, place in places.items():
                distance = height - place[2]
                at = [ray[i] * distance - place[i] for i in range(2)]
                check(all(abs(abs(a) - 0.5) > 1e-4 for a in at), "a pixel's centre on an edge is no test")
                if max(map(abs, at)) < 0.5 and distance < nearest:
                    wanted, nearest = label_color(label), distance
            check(image.pixel(x, y) == wanted, f"{x},{y}: {image.pixel(x, y)}, not {wanted}")


LABELS = {1: (-0.83, 0.41, 0), 300: (0.52, -0.33, 0.7), 32765: (0.87, 0.22, 0.2)}


def labels(test):
    """Labels are the exact colours of the scene, white elsewhere; moved squares are drawn where they moved to."""
    server = Server(test)
    camera = Camera(focal=37.3)
    check_labels(server.render(label_scene(LABELS), identity(0, 0, 3), "label", camera), LABELS, camera, 3)
    moved = {label: (-y, x + 0.03, z - 0.4) for label, (x, y, z) in LABELS.items()}
    check_labels(server.render(label_scene(moved), identity(0, 0, 3), "label", camera), moved, camera, 3)
    # Other labels of the same squares.
    renamed = {label + 7: place for label, place in moved.items()}
    check_labels(server.render(label_scene(renamed), identity(0, 0, 2.6), "label", camera), renamed, camera, 2.6)
    loads = [line for line in list(server.err) if "image of a new scene" in line]
    check(len(loads) == 1, f"the scene was loaded again: {loads}")


def tiny_png(color):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(b"\0" + bytes(color))) + chunk(b"IEND", b""))


def black_png(side):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 1, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(bytes((1 + (side + 7) // 8) * side), 9)) + chunk(b"IEND", b""))


def colors(test):
    """A lit red box over a floor, from both sides, and a textured square of a merged file; size and form of the PNG."""
    server = Server(test, "--background", "0000ff")
    camera = Camera()
    scene = Scene()
    scene.box(0.5, identity(0, 0, 0.5), (0.8, 0.05, 0.05))
    for side in (-1, 1):
        image = server.render(scene, look_at((3 * side, -3, 2), (0, 0, 0.5)), "color", camera)
        red, green, blue = image.pixel(32, 24)
        check(red > 90 and red > 2 * green and red > 2 * blue, f"the box is {red, green, blue}")
        check(image.pixel(1, 1) == (0, 0, 255), f"the background is {image.pixel(1, 1)}")
    # Lit from above: the world's Z is up.
    image = server.render(scene, look_at((0.01, 0, 4), (0, 0, 0)), "color", camera)
    above = image.pixel(32, 24)[0]
    image = server.render(scene, look_at((0.01, 0, -4), (0, 0, 0)), "color", camera)
    check(above > image.pixel(32, 24)[0] + 30, f"top {above}, bottom {image.pixel(32, 24)[0]}")
    # A merged file: its node is below a wrapper with RotX(90 degrees); the image has no type of its own.
    scene = Scene()
    points = [(-0.5, 0, 0), (0.5, 0, 0), (0.5, 1, 0), (-0.5, 1, 0)]
    mesh = scene.mesh(points, [(0, 1, 2), (0, 2, 3)], (1, 1, 1), texture=tiny_png((20, 220, 20)))
    scene.gltf["nodes"].append({"mesh": mesh, "name": "body"})
    scene.gltf["images"] = [{"uri": "data:application/octet-stream;base64," + base64.b64encode(tiny_png((20, 220, 20))).decode()}]
    upright = product(identity(0, 0, 1), [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    wrapper = scene.node(mesh, upright)
    scene.gltf["nodes"][wrapper].update(children=[0], mesh=mesh, name="scene::visual")
    del scene.gltf["nodes"][wrapper]["mesh"]
    # It reaches from z = 1 to z = 2, above the image's centre only.
    image = server.render(scene, look_at((0, -4, 1), (0, 0, 1)), "color", camera)
    red, green, blue = image.pixel(32, 18)
    check(green > 60 and green > 2 * red and green > 2 * blue, f"the square is {red, green, blue}")
    check(image.pixel(32, 30) == (0, 0, 255), f"below it is {image.pixel(32, 30)}")


def parallel(test):
    """Clients at once each get the image of their own scene and camera; a slow sender does not hold them up."""
    server = Server(test)
    camera = Camera(width=32, height=24, focal=20.9)
    slow = socket.create_connection(("127.0.0.1", server.port))
    slow.sendall(header(1000) + b"--")

    def ask(i):
        if i % 3 == 2:
            pose = look_at((0.1 * i, -2, 1.5), (0.1, 1, 0))
            check_floor(server.render(floor(), pose, "depth", camera), camera, pose, (0.1, 50.0))
            return
        places = {label + i: (x + 0.013 * i, y, z) for label, (x, y, z) in list(LABELS.items())[:1 + i % 3]}
        check_labels(server.render(label_scene(places), identity(0, 0, 3), "label", camera), places, camera, 3)
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        for done in [pool.submit(ask, i) for i in range(24)]:
            done.result()
    slow.close()


def raw(server, data, whole=True):
    """Sends bytes and returns (status, body) of the answer, or None if the connection ends without one."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=HANG_S) as connection:
        try:
            connection.sendall(data)
            if whole:
                connection.shutdown(socket.SHUT_WR)
            answer = b""
            while piece := connection.recv(65536):
                answer += piece
        except ConnectionError:
            return None
    if not answer:
        return None
    head, body = answer.split(b"\r\n\r\n", 1)
    return int(head.split()[1]), body


def header(length, *more):
    return "\r\n".join(["POST /render HTTP/1.1", "Host: localhost", f"Content-Length: {length}",
                        f"Content-Type: multipart/form-data; boundary={BOUNDARY}", *more, "", ""]).encode()


def hostile(test):
    """Errors are answered as Drake's client shows them, and the server renders on."""
    server = Server(test, "--timeout", "2", "--max-request", "1", "--connections", "40")
    camera, scene = Camera(width=16, height=12, focal=15.0), floor()
    pose = look_at((0, 0, 3), (0, 1, 0))
    text = scene.text(pose, camera)
    fields = form_fields(text, "depth", camera)
    body = form_body(fields, text)

    def works():
        check_floor(server.render(scene, pose, "depth", camera), camera, pose, (0.1, 50.0))
    works()

    # The form.
    for cut in (len(body) - 3, len(body) // 2, 40, 0):
        check_error(*server.post(body[:cut]), 400, "")
    server.refused(body, 415, "multipart/form-data", content_type="application/json")
    server.refused(body, 400, "boundary", content_type="multipart/form-data")
    server.refused(os.urandom(5000), 400, "boundary")
    server.refused(form_body({**fields, "width": "-1"}, text), 400, "width")
    server.refused(form_body({**fields, "scene_sha256": "0" * 64}, text), 400, "SHA-256")
    server.refused(form_body({**fields, "width": "8192", "height": "8192"}, text), 400, "too large")
    server.refused(form_body({**fields, "image_type": "x" * 9000}, text), 400, "image_type")
    server.refused(body, 404, "/render", path="/../../etc/passwd")
    check(server.post(form_body(fields, text, filename="../../../tmp/scene.gltf"))[0] == 200, "a file name is not used")

    # The scene.
    def refused_scene(data, fault):
        server.refused(form_body(form_fields(data, "color", camera), data), 400, fault)
    refused_scene(text.replace(b"data:application/octet-stream;base64,", b"file:///etc/passwd#", 1), "names a file")
    refused_scene(text[:-20], "not glTF in JSON")
    bomb = Scene()  # of one bit a pixel; it is not decoded
    bomb.quad(1, identity(), GREY, texture=black_png(9000))
    refused_scene(bomb.text(pose, camera), "decoded they take more than 256 MiB")
    refused_scene(b"[" * 500_000, "nests deeper")
    refused_scene(text.replace(b'"count": 4', b'"count": 4000000000'), "")
    refused_scene(text.replace(b"AAAAA", b"!!!!!", 1), "")
    huge = json.loads(text)
    huge["accessors"] = [{"componentType": 5126, "type": "VEC3", "count": 2_000_000_000} if a["type"] == "VEC3" else a
                         for a in huge["accessors"]]
    refused_scene(json.dumps(huge).encode(), "")
    works()

    # HTTP.
    check_error(*raw(server, header(10 << 30), whole=False), 413, "--max-request")
    check_error(*raw(server, b"POST /render HTTP/1.1\r\nX: " + b"x" * 40000, whole=False), 431, "header")
    check_error(*raw(server, b"\x16\x03\x01\x02\x00garbage\r\n\r\n"), 400, "HTTP/1.1")
    check_error(*raw(server, header(0).replace(b"Content-Length: 0\r\n", b"")), 411, "Content-Length")
    check_error(*raw(server, b"PUT /render HTTP/1.1\r\nHost: localhost\r\n\r\n"), 405, "POST")
    check(raw(server, b"GET / HTTP/1.0\r\n\r\n")[0] == 200, "GET /")
    check_error(*raw(server, header(5000) + b"--", whole=False), 408, "in time")
    check(raw(server, header(5000) + b"--") is None, "a request that ends early is answered")
    check(raw(server, b"POST /ren") is None, "a header that ends early is answered")

    # More connections than are served: idle ones make room.
    idle = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(100)]
    works()
    for connection in idle:
        connection.close()
    works()
    server.signal(signal.SIGTERM)
    server.expect_exit(0)


def spheres_scene(triangles, count=8):
    """Spheres of at least this many triangles together, on a floor, as objects of a simulation. The floor is node 0."""
    scene = floor(3.0)
    rings = math.ceil(0.5 + math.sqrt(0.25 + triangles / count / 4))  # 4 * rings * (rings - 1) triangles each
    sectors = 2 * rings
    points = [(0, 0, 1), (0, 0, -1)]
    points += [(math.sin(math.pi * r / rings) * math.cos(2 * math.pi * s / sectors),
                math.sin(math.pi * r / rings) * math.sin(2 * math.pi * s / sectors), math.cos(math.pi * r / rings))
               for r in range(1, rings) for s in range(sectors)]

    def at(r, s):
        return 2 + (r - 1) * sectors + s % sectors
    faces = [f for s in range(sectors) for f in ((0, at(1, s), at(1, s + 1)), (1, at(rings - 1, s + 1), at(rings - 1, s)))]
    faces += [f for r in range(1, rings - 1) for s in range(sectors)
              for f in ((at(r, s), at(r + 1, s), at(r + 1, s + 1)), (at(r, s), at(r + 1, s + 1), at(r, s + 1)))]
    for i in range(count):
        ball = [(0.12 * x, 0.12 * y, 0.12 * z) for x, y, z in points]
        angle = 2 * math.pi * i / count
        scene.node(scene.mesh(ball, faces, [0.3 + 0.5 * (i % 2), 0.7 - 0.06 * i, 0.2 + 0.1 * i]),
                   identity(0.4 * math.cos(angle), 0.4 * math.sin(angle), 0.12))
    return scene


def cached(test):
    """Later images of a scene load nothing, although poses and camera change. Prints the times."""
    server = Server(test)
    camera = Camera(width=640, height=480, focal=580.0)
    scene = spheres_scene(100_000)
    for image_type in ("color", "depth", "label"):
        times = []
        for i in range(4):
            scene.gltf["nodes"][1]["matrix"][14] = 0.12 + 0.05 * i
            text = scene.text(look_at((0.1 * i, -1, 1), (0, 0, 0)), camera)
            body = form_body(form_fields(text, image_type, camera), text)
            begin = time.monotonic()
            status, _ = server.post(body)
            times.append(time.monotonic() - begin)
            check(status == 200, f"status {status}")
        print(f"{image_type}: first {times[0] * 1e3:.0f} ms, later {min(times[1:]) * 1e3:.0f} ms, "
              f"{times[0] / min(times[1:]):.1f} times faster", flush=True)
    loads = [line for line in list(server.err) if "image of a new scene" in line]
    check(len(loads) == 2, f"one load for colours and one for depths and labels: {loads}")


def independent(test):
    """The image of a request depends on that request alone: exposure by a lamp, and shadows by the scene's size, are not
    those of the first request with the same content."""
    camera, pose = Camera(), look_at((0.3, -3, 2), (0, 0, 0.2))

    def text(lamp_height, box_at):
        scene = floor(half=2.0)
        scene.box(0.2, identity(0, 0, 0.3), (0.8, 0.3, 0.3))
        scene.box(0.2, identity(box_at, 0, 0.3), GREY)
        gltf = json.loads(scene.text(pose, camera))
        gltf["extensionsUsed"] = ["KHR_lights_punctual"]
        gltf["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1e6}]}}
        gltf["nodes"].append({"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0.5, 0.2, lamp_height]})
        root = gltf["nodes"][gltf["scenes"][0]["nodes"][0]]
        root["children"].append(len(gltf["nodes"]) - 1)
        return json.dumps(gltf).encode()

    def image(server, data):
        status, png = server.post(form_body(form_fields(data, "color", camera), data))
        check(status == 200, f"status {status}: {png[:300]}")
        return png
    near, far = text(2, 0.8), text(2000, 800)
    wanted = image(Server(test), near)
    server = Server(test)
    check(image(server, far) != wanted, "the scenes look alike, which is no test")
    check(image(server, near) == wanted, "the first request of the content decides on later images")
    check(len([line for line in list(server.err) if "image of a new scene" in line]) == 1, "the scene was not cached")


def command(test):
    """fire3dv --drake runs the server; addresses, options and a missing program; a stop during an image."""
    fire3dv, program = test.programs_at["fire3dv"], test.programs_at["fire3dv-drake"]
    server = Server(test, program=[fire3dv, "--drake", "127.0.0.1:0", "--samples", "1"])
    taken = f"127.0.0.1:{server.port}"

    def refused(code, text, *arguments):
        result = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=HANG_S)
        check(result.returncode == code and text in result.stderr and "fire3dv-drake: error: " in result.stderr,
              f"{arguments}: {result}")
    refused(1, "the port is in use", taken)
    refused(1, "open to the network", "0.0.0.0:0")
    refused(1, "must be HOST:PORT", "nonsense")
    refused(2, "address is required")
    refused(2, "--depth", "127.0.0.1:0", "--depth", "8u")
    refused(2, "--background", "127.0.0.1:0", "--background", "sky")
    alone = test.path("fire3dv")
    shutil.copy(fire3dv, alone)  # without the other programs beside it
    result = subprocess.run([alone, "--drake", "127.0.0.1:0"], capture_output=True, text=True, timeout=HANG_S)
    check(result.returncode == 1 and "no render server for Drake" in result.stderr, f"{result}")

    # A request in progress does not hold up the end.
    camera = Camera(width=640, height=480, focal=580.0)
    scene = spheres_scene(150_000)
    text = scene.text(look_at((0, -1, 1), (0, 0, 0)), camera)
    body = form_body(form_fields(text, "color", camera), text)
    with socket.create_connection(("127.0.0.1", server.port)) as connection:
        connection.sendall(header(len(body)) + body)
        time.sleep(0.2)
        server.signal(signal.SIGTERM)
        check(server.wait() == 0, f"the server ended with {server.process.returncode}:\n{server.stderr_text()}")
    wait_until("the port to be free", lambda: socket.socket().connect_ex(("127.0.0.1", server.port)) != 0)


if __name__ == "__main__":
    main({"depth": depth, "labels": labels, "colors": colors, "parallel": parallel, "hostile": hostile, "cached": cached,
          "independent": independent, "command": command}, ["fire3dv", "fire3dv-drake"])
