"""Requests as Drake's RenderEngineGltfClient makes them: glTF as VTK's exporter writes it, and the form that libcurl posts.

Frames: Drake's world is Z up. A camera pose is a 4x4 matrix as rows; it looks along its -Z, as in glTF.
"""
import base64
import hashlib
import http.client
import json
import math
import struct
import zlib

from harness import Program, vulkan_environment
from image_reader import Picture, check, unfilter

WHITE = (255, 255, 255)
BOUNDARY = "------------------------d74496d66958873e"


def identity(x=0.0, y=0.0, z=0.0):
    return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]


def product(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)] for r in range(4)]


def look_at(eye, target, up=(0, 0, 1)):
    """Pose of a glTF camera at `eye` that looks at `target`."""
    def unit(v):
        length = math.sqrt(sum(x * x for x in v))
        return [x / length for x in v]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    back = unit([e - t for e, t in zip(eye, target)])
    right = unit(cross(up, back))
    above = cross(back, right)
    return [[right[r], above[r], back[r], eye[r]] for r in range(3)] + [[0, 0, 0, 1]]


def column_major(matrix):
    return [float(matrix[r][c]) for c in range(4) for r in range(4)]


class Scene:
    """glTF document in the manner of VTK: a buffer for each array, no normals, all nodes below "Renderer Node"."""

    def __init__(self):
        self.gltf = {"asset": {"generator": "VTK", "version": "2.0"}, "scene": 0, "accessors": [], "buffers": [],
                     "bufferViews": [], "materials": [], "meshes": [], "nodes": [], "cameras": [], "scenes": [{"nodes": []}]}
        self.children = []

    def _view(self, data, target=None):
        self.gltf["buffers"].append({"byteLength": len(data), "uri": "data:application/octet-stream;base64," +
                                     base64.b64encode(data).decode()})
        view = {"buffer": len(self.gltf["buffers"]) - 1, "byteLength": len(data), "byteOffset": 0}
        self.gltf["bufferViews"].append({**view, "target": target} if target else view)
        return len(self.gltf["bufferViews"]) - 1

    def _accessor(self, data, target, **fields):
        self.gltf["accessors"].append({"bufferView": self._view(data, target), "byteOffset": 0, **fields})
        return len(self.gltf["accessors"]) - 1

    def mesh(self, points, triangles, color, texture=None):
        """color: baseColorFactor without alpha. texture: bytes of an image. Returns the mesh's index."""
        attributes = {
            "POSITION": self._accessor(struct.pack(f"<{3 * len(points)}f", *(x for p in points for x in p)), 34962,
                                       componentType=5126, count=len(points), type="VEC3",
                                       min=[min(p[i] for p in points) for i in range(3)],
                                       max=[max(p[i] for p in points) for i in range(3)]),
            "TEXCOORD_0": self._accessor(struct.pack(f"<{2 * len(points)}f", *([0.5] * 2 * len(points))), 34962,
                                         componentType=5126, count=len(points), type="VEC2")}
        indices = self._accessor(struct.pack(f"<{3 * len(triangles)}I", *(i for t in triangles for i in t)), 34963,
                                 componentType=5125, count=3 * len(triangles), type="SCALAR")
        pbr = {"baseColorFactor": [*color, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
        if texture:
            view = self._view(texture)
            self.gltf["images"] = [{"bufferView": view, "mimeType": "image/png"}]
            self.gltf["samplers"] = [{"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071}]
            self.gltf["textures"] = [{"source": 0, "sampler": 0}]
            pbr["baseColorTexture"] = {"index": 0, "texCoord": 0}
        self.gltf["materials"].append({"pbrMetallicRoughness": pbr})
        self.gltf["meshes"].append({"name": f"mesh{len(self.gltf['meshes'])}", "primitives": [{
            "attributes": attributes, "indices": indices, "material": len(self.gltf["materials"]) - 1, "mode": 4}]})
        return len(self.gltf["meshes"]) - 1

    def node(self, mesh, pose, name=None):
        self.gltf["nodes"].append({"mesh": mesh, "matrix": column_major(pose), "name": name or f"mesh{mesh}"})
        self.children.append(len(self.gltf["nodes"]) - 1)
        return self.children[-1]

    def quad(self, half, pose, color, **options):
        """Square in its own XY plane."""
        points = [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]
        return self.node(self.mesh(points, [(0, 1, 2), (0, 2, 3)], color, **options), pose)

    def box(self, half, pose, color):
        """Cube with a vertex for each corner of each face, as VTK's cube source has them."""
        points, triangles = [], []
        for axis in range(3):
            for side in (-1, 1):
                first = len(points)
                for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                    point = [0.0, 0.0, 0.0]
                    point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3] = side * half, u * half * side, v * half
                    points.append(tuple(point))
                triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
        return self.node(self.mesh(points, triangles, color), pose)

    def text(self, camera_pose, camera):
        gltf = dict(self.gltf)
        count = len(gltf["nodes"])
        gltf["nodes"] = [*gltf["nodes"], {"camera": 0, "matrix": column_major(camera_pose), "name": "Camera Node"},
                         {"children": [*self.children, count], "name": "Renderer Node"}]
        gltf["scenes"] = [{"nodes": [count + 1], "name": "Layer 0"}]
        gltf["cameras"] = [{"type": "perspective", "perspective": {
            "aspectRatio": camera.width / camera.height, "yfov": camera.fov_y(), "znear": camera.near, "zfar": camera.far}}]
        return json.dumps(gltf).encode()


class Camera:
    """Intrinsics as Drake's CameraInfo has them: pixels from the upper left corner of the image."""

    def __init__(self, width=64, height=48, focal=60.0, center=None, near=0.01, far=100.0):
        self.width, self.height, self.focal, self.near, self.far = width, height, focal, near, far
        self.center = center or (width / 2, height / 2)

    def fov_y(self):
        return 2 * math.atan(self.height / (2 * self.focal))

    def ray(self, pose, x, y):
        """Direction in the world through a pixel's centre, with length 1 along the camera's axis."""
        local = ((x + 0.5 - self.center[0]) / self.focal, -(y + 0.5 - self.center[1]) / self.focal, -1)
        return [sum(pose[r][c] * local[c] for c in range(3)) for r in range(3)]


def form_fields(scene, image_type, camera, depth_range=(0.1, 50.0)):
    """The fields in Drake's order: those of text sorted by name, then the file. Doubles have 6 decimals."""
    fields = {"scene_sha256": hashlib.sha256(scene).hexdigest(), "image_type": image_type, "width": str(camera.width),
              "height": str(camera.height), "submit": "Render"}
    numbers = {"near": camera.near, "far": camera.far, "focal_x": camera.focal, "focal_y": camera.focal,
               "fov_x": 2 * math.atan(camera.width / (2 * camera.focal)), "fov_y": camera.fov_y(),
               "center_x": camera.center[0], "center_y": camera.center[1]}
    if image_type == "depth":
        numbers.update(min_depth=depth_range[0], max_depth=depth_range[1])
    fields.update((name, f"{value:.6f}") for name, value in numbers.items())
    return dict(sorted(fields.items()))


def form_body(fields, scene, filename="0000000000000000001-color.gltf"):
    parts = [f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n{value}\r\n'.encode()
             for name, value in fields.items()]
    parts.append((f'--{BOUNDARY}\r\nContent-Disposition: form-data; name="scene"; filename="{filename}"\r\n'
                  "Content-Type: model/gltf+json\r\n\r\n").encode() + scene + b"\r\n")
    return b"".join(parts) + f"--{BOUNDARY}--\r\n".encode()


class Server(Program):
    """fire3dv-drake on a free port of loopback."""

    def __init__(self, test, *arguments, program=None):
        command = program or [test.programs_at["fire3dv-drake"], "127.0.0.1:0"]
        super().__init__(test, "fire3dv-drake", [*command, "--validation", "--cache", "off", *arguments], vulkan_environment())
        self.port = int(self.wait_err(r"serving Drake on http://127\.0\.0\.1:(\d+)/render").group(1))

    def post(self, body, content_type=f"multipart/form-data; boundary={BOUNDARY}", path="/render"):
        """Returns status and body of the answer, on a connection of its own as libcurl's easy handle."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=240)
        try:
            connection.request("POST", path, body, {"Content-Type": content_type, "Accept": "*/*"})
            response = connection.getresponse()
            return response.status, response.read()
        finally:
            connection.close()

    def render(self, scene, pose, image_type, camera, **options):
        """Image as Drake's client accepts it: a Picture, or depths as rows of numbers."""
        text = scene.text(pose, camera)
        status, data = self.post(form_body(form_fields(text, image_type, camera, **options), text))
        check(status == 200, f"{image_type}: status {status}: {data[:500]}")
        image = read_depth(data) if image_type == "depth" else read_colors(data)
        size = (len(image[0]), len(image)) if image_type == "depth" else (image.width, image.height)
        check(size == (camera.width, camera.height), f"{image_type}: {size}")
        return image

    def refused(self, body, status, text, **options):
        """Expects an error in the form of Drake's server that its client shows."""
        got, data = self.post(body, **options)
        check_error(got, data, status, text)


def check_error(got, data, status, text):
    check(got == status and len(data) < 8192, f"status {got}, not {status}: {data[:300]}")
    error = json.loads(data)
    check(error["error"] is True and error["code"] == status and text in error["message"], f"{text}: {error}")


def read_colors(data):
    """8-bit PNG with 3 or 4 channels."""
    check(data[:8] == b"\x89PNG\r\n\x1a\n", f"no PNG: {data[:40]}")
    at, header, pixels = 8, None, b""
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            header = struct.unpack_from(">IIBBBBB", data, at + 8)
        if kind == b"IDAT":
            pixels += data[at + 8:at + 8 + length]
        at += 12 + length
    width, height, depth, color = header[:4]
    check(depth == 8 and color in (2, 6), f"PNG of {header}")
    return Picture(width, height, unfilter(zlib.decompress(pixels), width, height, 3 if color == 2 else 4))


def read_depth(data):
    """TIFF with one channel of floats, or of 16-bit integers, from the top. Returns rows of numbers."""
    check(data[:4] == b"II*\0", f"no TIFF: {data[:40]}")
    at = struct.unpack_from("<I", data, 4)[0]
    tags = {}
    for i in range(struct.unpack_from("<H", data, at)[0]):
        tag, kind, count, value = struct.unpack_from("<HHII", data, at + 2 + 12 * i)
        check(count == 1 and kind in (3, 4), f"tag {tag}")
        tags[tag] = value
    width, height, bits, sample = tags[256], tags[257], tags[258], tags[339]
    check(tags[259] == 1 and tags[262] == 1 and tags[274] == 1 and tags[277] == 1 and tags[278] == height, f"{tags}")
    check((bits, sample) in ((32, 3), (16, 1)), f"{tags}")
    check(tags[279] == width * height * bits // 8 == len(data) - tags[273], f"{tags}, {len(data)} bytes")
    values = struct.unpack_from(f"<{width * height}{'f' if bits == 32 else 'H'}", data, tags[273])
    return [values[y * width:(y + 1) * width] for y in range(height)]
