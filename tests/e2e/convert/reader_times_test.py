#!/usr/bin/env python3
"""Every reader takes time n log n: files of each format are doubled until reading takes some time, and the processor times of
the last sizes give an exponent. One above MOST_EXPONENT fails: n log n beyond the caches measures up to 1.4 on a loaded
machine, and 2 is quadratic.

reader_times_test.py FIRE3DV FIRE3DV_CONVERT FIRE3DV_INSPECT [--report] [CASE...]

Times are processor time of one process, less that of a tiny file. Cases too fast to measure at their largest size pass."""
import io
import json
import math
import os
import random
import struct
import subprocess
import sys
import tempfile
import zipfile

MOST_EXPONENT = 1.5
ENOUGH_S = 1.0  # of the largest file
LEAST_S = 0.15  # below, noise hides the exponent
HANG_S = 120
MOST_BYTES = 256 << 20  # of the file that is read

TRIANGLE_OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def link(i, inside=""):
    return f'<link name="l{i}">{inside}</link>\n'


def joint(i, parent, kind="fixed", inside=""):
    return f'<joint name="j{i}" type="{kind}"><parent link="l{parent}"/><child link="l{i}"/>{inside}</joint>\n'


BOX = '<visual><geometry><box size="1 1 1"/></geometry></visual>'


def urdf(body):
    return f'<?xml version="1.0"?>\n<robot name="r">\n{body}</robot>\n'


def xacro(body):
    return f'<?xml version="1.0"?>\n<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">\n{body}<link name="l0"/></robot>\n'


def mjcf(body, more=""):
    return f"<mujoco>{more}<worldbody>{body}</worldbody></mujoco>"


def sdf(body):
    return f'<sdf version="1.9"><world name="w">{body}</world></sdf>'


def sdf_model(i, links):
    return f'<model name="m{i}">{links}</model>'


def sdf_link(i, visuals=1):
    shape = "".join(f'<visual name="v{k}"><geometry><box><size>1 1 1</size></box></geometry></visual>' for k in range(visuals))
    return f'<link name="l{i}">{shape}</link>'


def gear(n):
    points = [(math.cos(2 * math.pi * i / n) * (1.3 if i % 2 else 1), math.sin(2 * math.pi * i / n) * (1.3 if i % 2 else 1)) for i in range(n)]
    return points


def bowl(n):
    half = n // 2
    xs = [-1 + 2 * i / (half - 1) for i in range(half)]
    return [(x, 0.5 - 0.5 * x * x) for x in xs] + [(x, 1 + 0.5 * x * x) for x in reversed(xs)]


def scribble(n):
    numbers = random.Random(4)
    return [(numbers.random(), numbers.random()) for _ in range(n)]


def obj_polygon(points):
    return "".join(f"v {x!r} {y!r} 0\n" for x, y in points) + "f " + " ".join(str(i + 1) for i in range(len(points))) + "\n"


def ply(n, header, rows, kind="ascii"):
    return f"ply\nformat {kind} 1.0\n{header}end_header\n" + rows


def ply_polygon(points):
    n = len(points)
    return ply(n, f"element vertex {n}\nproperty double x\nproperty double y\nproperty double z\nelement face 1\nproperty list int int vertex_indices\n",
               "".join(f"{x!r} {y!r} 0\n" for x, y in points) + f"{n} " + " ".join(map(str, range(n))) + "\n")


def ascii_stl(n):
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 {0}\nvertex 1 0 {0}\nvertex 0 1 {0}\nendloop\nendfacet\n"
    return "solid a\n" + "".join(facet.format(i) for i in range(n)) + "endsolid a\n"


def binary_stl(n):
    return b"\0" * 80 + struct.pack("<I", n) + b"".join(struct.pack("<12fH", 0, 0, 1, 0, 0, i, 1, 0, i, 0, 1, i, 0) for i in range(n))


def dae(geometries, nodes, more=""):
    return ('<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><up_axis>Z_UP</up_axis></asset>'
            f'{more}<library_geometries>{geometries}</library_geometries><library_visual_scenes><visual_scene id="s">{nodes}</visual_scene>'
            '</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>')


def dae_geometry(name, n=1, polygon=False):
    positions = " ".join(f"0 0 {i} 1 0 {i} 0 1 {i}" for i in range(n))
    indices = " ".join(map(str, range(3 * n)))
    faces = (f'<polylist count="{n}"><input semantic="VERTEX" source="#{name}v" offset="0"/><vcount>{"3 " * n}</vcount><p>{indices}</p></polylist>'
             if polygon else f'<triangles count="{n}"><input semantic="VERTEX" source="#{name}v" offset="0"/><p>{indices}</p></triangles>')
    return (f'<geometry id="{name}"><mesh><source id="{name}p"><float_array id="{name}a" count="{9 * n}">{positions}</float_array><technique_common>'
            f'<accessor source="#{name}a" count="{3 * n}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>'
            f'</accessor></technique_common></source><vertices id="{name}v"><input semantic="POSITION" source="#{name}p"/></vertices>{faces}</mesh></geometry>')


def dae_polygon(points):
    n = len(points)
    text = dae_geometry("g")
    positions = " ".join(f"{x!r} {y!r} 0" for x, y in points)
    text = text[:text.index("<float_array")] + f'<float_array id="ga" count="{3 * n}">{positions}</float_array>' + text[text.index("<technique_common>"):]
    text = text.replace('count="3" stride', f'count="{n}" stride')
    text = text[:text.index("<triangles")] + (f'<polylist count="1"><input semantic="VERTEX" source="#gv" offset="0"/><vcount>{n}</vcount>'
                                              f'<p>{" ".join(map(str, range(n)))}</p></polylist></mesh></geometry>')
    return dae(text, dae_node(0, "g"))


def dae_holes(n):
    """A sheet of n square holes."""
    side = math.isqrt(n)
    points, holes = [(0, 0), (side, 0), (side, side), (0, side)], ""
    for i in range(side * side):
        x, y, first = i % side + 0.25, i // side + 0.25, len(points)
        points += [(x, y), (x, y + 0.5), (x + 0.5, y + 0.5), (x + 0.5, y)]
        holes += f"<h>{first} {first + 1} {first + 2} {first + 3}</h>"
    text = dae_polygon(points)
    begin, end = text.index("<polylist"), text.index("</polylist>") + len("</polylist>")
    return (text[:begin] + '<polygons count="1"><input semantic="VERTEX" source="#gv" offset="0"/><ph><p>0 1 2 3</p>' + holes + "</ph></polygons>"
            + text[end:])


def dae_node(i, geometry=None, inside=""):
    return f'<node id="n{i}" name="n{i}">' + (f'<instance_geometry url="#{geometry}"/>' if geometry else "") + inside + "</node>"


def three_mf(resources, items):
    model = ('<?xml version="1.0"?><model unit="meter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
             f"<resources>{resources}</resources><build>{items}</build></model>")
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", '<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
                         '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
                         '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')
        archive.writestr("_rels/.rels", '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
                         '<Relationship Target="/3D/3dmodel.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>')
        archive.writestr("3D/3dmodel.model", model)
    return data.getvalue()


def mf_object(i, n=1):
    vertices = "".join(f'<vertex x="0" y="0" z="{k}"/><vertex x="1" y="0" z="{k}"/><vertex x="0" y="1" z="{k}"/>' for k in range(n))
    triangles = "".join(f'<triangle v1="{3 * k}" v2="{3 * k + 1}" v3="{3 * k + 2}"/>' for k in range(n))
    return f'<object id="{i}" type="model"><mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object>'


def gltf(parts, buffer=b""):
    """A glTF JSON with one triangle; parts replaces members."""
    data = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0) + buffer
    import base64
    scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
             "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
             "bufferViews": [{"buffer": 0, "byteLength": 36}],
             "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]}
    scene.update(parts)
    return json.dumps(scene)


def gltf_nodes(n, children):
    nodes = [{"name": f"n{i}", **({"mesh": 0} if i % 2 == 0 else {})} for i in range(n)]
    for i, below in children.items():
        nodes[i]["children"] = below
    roots = sorted(set(range(n)) - {c for below in children.values() for c in below})
    return gltf({"nodes": nodes, "scenes": [{"nodes": roots}]})


def gltf_skins(n):
    joints = [{"name": f"j{i}"} for i in range(n)]
    nodes = joints + [{"mesh": 0, "skin": i} for i in range(n)]
    return gltf({"nodes": nodes, "scenes": [{"nodes": list(range(2 * n))}], "skins": [{"joints": [i]} for i in range(n)]})


def gltf_animations(n):
    times = struct.pack("<2f", 0, 1) + struct.pack("<6f", 0, 0, 0, 1, 1, 1)
    nodes = [{"name": f"n{i}", "mesh": 0} for i in range(n)]
    return gltf({"nodes": nodes, "scenes": [{"nodes": list(range(n))}],
                 "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8}, {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
                 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                               {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
                               {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
                 "animations": [{"name": "a", "samplers": [{"input": 1, "output": 2}],
                                 "channels": [{"sampler": 0, "target": {"node": i, "path": "translation"}} for i in range(n)]}]}, times)


def adf(bodies, joints=""):
    names = [f"BODY b{i}" for i in range(bodies)]
    text = f"bodies: [{', '.join(names)}]\njoints: [{joints and ', '.join(f'JOINT j{i}' for i in range(1, bodies))}]\n"
    for i in range(bodies):
        text += f"BODY b{i}:\n  name: b{i}\n  shape: BOX\n  geometry: {{x: 1, y: 1, z: 1}}\n  location:\n    position: {{x: {i}, y: 0, z: 0}}\n    orientation: {{r: 0, p: 0, y: 0}}\n"
    for i in range(1, bodies) if joints else ():
        parent = 0 if joints == "star" else i - 1
        text += (f"JOINT j{i}:\n  name: j{i}\n  parent: BODY b{parent}\n  child: BODY b{i}\n  parent axis: {{x: 0, y: 0, z: 1}}\n  child axis: {{x: 0, y: 0, z: 1}}\n"
                 "  parent pivot: {x: 1, y: 0, z: 0}\n  child pivot: {x: 0, y: 0, z: 0}\n  type: revolute\n")
    return text


def mcap(messages, channels=1, metadata=0, attachments=0, schemas=1, size=40):
    def text(value):
        return struct.pack("<I", len(value)) + value.encode()

    def record(op, body):
        return bytes([op]) + struct.pack("<Q", len(body)) + body

    out = [b"\x89MCAP0\r\n", record(1, text("") + text("test"))]
    for i in range(schemas):
        out.append(record(3, struct.pack("<H", i + 1) + text(f"s{i}") + text("json") + text("{}")))
    for i in range(channels):
        out.append(record(4, struct.pack("<HH", i, 1) + text(f"/c{i}") + text("json") + struct.pack("<I", 0)))
    for i in range(metadata):
        out.append(record(12, text(f"m{i}") + struct.pack("<I", 0)))
    for i in range(messages):
        out.append(record(5, struct.pack("<HIQQ", i % max(channels, 1), i, i, i) + b"x" * size))
    out += [record(15, struct.pack("<I", 0)), record(2, struct.pack("<QQI", 0, 0, 0)), b"\x89MCAP0\r\n"]
    return b"".join(out)


def chain(n):
    return urdf(link(0) + "".join(link(i, BOX) + joint(i, i - 1) for i in range(1, n)))


def random_joints(n):
    numbers = random.Random(1)
    order = list(range(1, n))
    numbers.shuffle(order)
    return urdf("".join(joint(i, numbers.randrange(i)) for i in order) + "".join(link(i) for i in range(n)))


def overlay(edits):
    return json.dumps({"fire3dv_overlay": {"version": 2, "scene": "scene.gltf", "edits": edits}})


def mtl(n):
    return {"a.mtl": "".join(f"newmtl m{i}\nKd {i / n} 0 0\n" for i in range(n)),
            "": "mtllib a.mtl\n" + TRIANGLE_OBJ + "".join(f"usemtl m{i}\nf 1 2 3\n" for i in range(n))}


# Name: (file name, first size, file of a size). Deep nesting is refused, and not measured; the paths of a chain of nodes are
# quadratic by themselves. A dictionary has more files; that of "" is the file itself.
CASES = {
    "obj_triangles": ("a.obj", 20000, lambda n: "".join(f"v 0 0 {i}\nv 1 0 {i}\nv 0 1 {i}\nf -3 -2 -1\n" for i in range(n))),
    "obj_shared_vertices": ("a.obj", 10000, lambda n: "".join(f"v {i} {i % 7} {i % 3}\n" for i in range(n)) + "".join(f"f {i + 1} {i + 2} {i + 3}\n" for i in range(n - 3))),
    "obj_normals": ("a.obj", 10000, lambda n: "".join(f"v {i} {i % 7} {i % 3}\nvn 0 0 1\nvt 0 {i}\n" for i in range(n)) + "".join(f"f {i + 1}/{i + 1}/{i + 1} {i + 2}/{i + 2}/{i + 2} {i + 3}/{i + 3}/{i + 3}\n" for i in range(n - 3))),
    "obj_fan": ("a.obj", 10000, lambda n: "v 0 0 9\n" + "".join(f"v {math.cos(i)} {math.sin(i)} 0\n" for i in range(n)) + "".join(f"f 1 {i + 2} {i + 3}\n" for i in range(n - 1))),
    "obj_one_point": ("a.obj", 10000, lambda n: "v 0 0 0\n" * n + "v 1 0 0\nv 0 1 0\n" + "".join(f"f {i + 1} {n + 1} {n + 2}\n" for i in range(n))),
    "obj_objects": ("a.obj", 500, lambda n: "".join(f"o o{i}\nv 0 0 {i}\nv 1 0 {i}\nv 0 1 {i}\nf -3 -2 -1\n" for i in range(n))),
    "obj_groups": ("a.obj", 500, lambda n: "".join(f"g g{i}\nv 0 0 {i}\nv 1 0 {i}\nv 0 1 {i}\nf -3 -2 -1\n" for i in range(n))),
    "obj_same_names": ("a.obj", 500, lambda n: "".join(f"o o\nv 0 0 {i}\nv 1 0 {i}\nv 0 1 {i}\nf -3 -2 -1\n" for i in range(n))),
    "obj_materials": ("a.obj", 500, mtl),
    "obj_unknown_materials": ("a.obj", 500, lambda n: TRIANGLE_OBJ + "".join(f"usemtl m{i}\nf 1 2 3\n" for i in range(n))),
    "obj_mtllibs": ("a.obj", 500, lambda n: TRIANGLE_OBJ + "".join(f"mtllib m{i}.mtl\n" for i in range(n)) + "f 1 2 3\n"),
    "obj_gear": ("a.obj", 20000, lambda n: obj_polygon(gear(n))),
    "obj_bowl": ("a.obj", 20000, lambda n: obj_polygon(bowl(n))),
    "obj_scribble": ("a.obj", 20000, lambda n: obj_polygon(scribble(n))),
    "obj_comments": ("a.obj", 50000, lambda n: TRIANGLE_OBJ + "# \\\n" * n + "f 1 2 3\n"),
    "obj_continued": ("a.obj", 50000, lambda n: TRIANGLE_OBJ + "f 1 2 3" + " \\\n 1" * n + "\n"),
    "stl_ascii": ("a.stl", 10000, ascii_stl),
    "stl_solids": ("a.stl", 1000, lambda n: "".join(ascii_stl(1).replace("solid a", f"solid a{i}") for i in range(n))),
    "stl_binary": ("a.stl", 20000, binary_stl),
    "ply_ascii": ("a.ply", 10000, lambda n: ply(n, f"element vertex {3 * n}\nproperty float x\nproperty float y\nproperty float z\nelement face {n}\nproperty list uchar int vertex_indices\n", "".join(f"0 0 {i}\n1 0 {i}\n0 1 {i}\n" for i in range(n)) + "".join(f"3 {3 * i} {3 * i + 1} {3 * i + 2}\n" for i in range(n)))),
    "ply_polygon": ("a.ply", 20000, lambda n: ply_polygon(bowl(n))),
    "ply_properties": ("a.ply", 1000, lambda n: ply(n, "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n" + "".join(f"property float p{i}\n" for i in range(n)) + "element face 1\nproperty list uchar int vertex_indices\n", ("0 0 0" + " 1" * n + "\n") + ("1 0 0" + " 1" * n + "\n") + ("0 1 0" + " 1" * n + "\n") + "3 0 1 2\n")),
    "ply_elements": ("a.ply", 1000, lambda n: ply(n, "".join(f"element e{i} 0\nproperty float x\n" for i in range(n)) + "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")),
    "dae_triangles": ("a.dae", 5000, lambda n: dae(dae_geometry("g", n), dae_node(0, "g"))),
    "dae_polylist": ("a.dae", 5000, lambda n: dae(dae_geometry("g", n, True), dae_node(0, "g"))),
    "dae_polygon": ("a.dae", 20000, lambda n: dae_polygon(bowl(n))),
    "dae_holes": ("a.dae", 2000, dae_holes),
    "dae_nodes": ("a.dae", 500, lambda n: dae(dae_geometry("g"), "".join(dae_node(i, "g") for i in range(n)))),
    "dae_geometries": ("a.dae", 250, lambda n: dae("".join(dae_geometry(f"g{i}") for i in range(n)), "".join(dae_node(i, f"g{i}") for i in range(n)))),
    "dae_instances": ("a.dae", 500, lambda n: dae(dae_geometry("g"), dae_node(0, None, '<instance_geometry url="#g"/>' * n))),
    "dae_materials": ("a.dae", 250, lambda n: dae(dae_geometry("g"), dae_node(0, "g"), "<library_effects>" + "".join(f'<effect id="e{i}"><profile_COMMON><technique sid="c"><lambert><diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON></effect>' for i in range(n)) + "</library_effects><library_materials>" + "".join(f'<material id="m{i}"><instance_effect url="#e{i}"/></material>' for i in range(n)) + "</library_materials>")),
    "3mf_triangles": ("a.3mf", 10000, lambda n: three_mf(mf_object(1, n), '<item objectid="1"/>')),
    "3mf_objects": ("a.3mf", 500, lambda n: three_mf("".join(mf_object(i + 1) for i in range(n)), "".join(f'<item objectid="{i + 1}"/>' for i in range(n)))),
    "3mf_items": ("a.3mf", 500, lambda n: three_mf(mf_object(1), '<item objectid="1"/>' * n)),
    "3mf_components": ("a.3mf", 500, lambda n: three_mf(mf_object(1) + '<object id="2"><components>' + '<component objectid="1"/>' * n + "</components></object>", '<item objectid="2"/>')),
    "3mf_materials": ("a.3mf", 500, lambda n: three_mf('<basematerials id="9999999">' + "".join(f'<base name="b{i}" displaycolor="#{i % 0xffffff:06x}"/>' for i in range(n)) + "</basematerials>" + mf_object(1), '<item objectid="1"/>')),
    "gltf_nodes": ("a.gltf", 2000, lambda n: gltf_nodes(n, {})),
    "gltf_star": ("a.gltf", 2000, lambda n: gltf_nodes(n, {0: list(range(1, n))})),
    "gltf_tree": ("a.gltf", 2000, lambda n: gltf_nodes(n, {i: [c for c in (2 * i + 1, 2 * i + 2) if c < n] for i in range(n // 2)})),
    "gltf_same_names": ("a.gltf", 2000, lambda n: gltf({"nodes": [{"name": "n", "mesh": 0}] * n, "scenes": [{"nodes": list(range(n))}]})),
    "gltf_meshes": ("a.gltf", 1000, lambda n: gltf({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}] * n, "nodes": [{"mesh": i} for i in range(n)], "scenes": [{"nodes": list(range(n))}]})),
    "gltf_primitives": ("a.gltf", 1000, lambda n: gltf({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * n}]})),
    "gltf_materials": ("a.gltf", 1000, lambda n: gltf({"materials": [{"name": f"m{i}", "pbrMetallicRoughness": {"metallicFactor": i / n}} for i in range(n)], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": i} for i in range(n)]}]})),
    "gltf_accessors": ("a.gltf", 2000, lambda n: gltf({"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}] * n})),
    "gltf_skins": ("a.gltf", 500, gltf_skins),
    "gltf_animations": ("a.gltf", 1000, gltf_animations),
    "gltf_extras": ("a.gltf", 20000, lambda n: gltf({"extras": {f"k{i}": i for i in range(n)}})),
    "gltf_white": ("a.gltf", 100000, lambda n: gltf({}) + " " * n),
    "urdf_chain": ("a.urdf", 500, chain),
    "urdf_star": ("a.urdf", 500, lambda n: urdf(link(0) + "".join(link(i, BOX) + joint(i, 0) for i in range(1, n)))),
    "urdf_random": ("a.urdf", 500, random_joints),
    "urdf_movable": ("a.urdf", 500, lambda n: urdf(link(0) + "".join(link(i) + joint(i, i - 1, "revolute", '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>') for i in range(1, n)))),
    "urdf_mimic": ("a.urdf", 500, lambda n: urdf(link(0) + link(1) + joint(1, 0, "revolute", '<limit lower="-1" upper="1" effort="1" velocity="1"/>') + "".join(link(i) + joint(i, 0, "revolute", f'<mimic joint="j{i - 1}"/><limit lower="-1" upper="1" effort="1" velocity="1"/>') for i in range(2, n)))),
    "urdf_visuals": ("a.urdf", 1000, lambda n: urdf(link(0, BOX * n))),
    "urdf_materials": ("a.urdf", 1000, lambda n: urdf("".join(f'<material name="m{i}"><color rgba="{i / n} 0 0 1"/></material>' for i in range(n)) + link(0, "".join(BOX.replace("</visual>", f'<material name="m{i}"/></visual>') for i in range(n))))),
    "urdf_missing_meshes": ("a.urdf", 500, lambda n: urdf(link(0, "".join(f'<visual><geometry><mesh filename="m{i}.obj"/></geometry></visual>' for i in range(n))))),
    "urdf_missing_packages": ("a.urdf", 500, lambda n: urdf(link(0, "".join(f'<visual><geometry><mesh filename="package://p{i}/m.obj"/></geometry></visual>' for i in range(n))))),
    "urdf_unknown": ("a.urdf", 2000, lambda n: urdf(link(0) + "".join(f"<u{i}/>" for i in range(n)))),
    "urdf_comments": ("a.urdf", 20000, lambda n: urdf("<!-- -->\n" * n + link(0, BOX))),
    "urdf_attributes": ("a.urdf", 2000, lambda n: urdf(link(0).replace("<link", "<link " + " ".join(f'a{i}="1"' for i in range(n))))),
    "urdf_unclosed": ("a.urdf", 20000, lambda n: urdf(link(0)) + "<!-- " * n),
    "xacro_properties": ("a.xacro", 1000, lambda n: xacro("".join(f'<xacro:property name="p{i}" value="{"${p%d + 1}" % (i - 1) if i else "0"}"/>\n' for i in range(n)))),
    "xacro_macros": ("a.xacro", 1000, lambda n: xacro("".join(f'<xacro:macro name="m{i}" params="a"><link name="x${{a}}"/></xacro:macro>\n' for i in range(n)))),
    "xacro_calls": ("a.xacro", 500, lambda n: xacro('<xacro:macro name="m" params="a"><link name="x${a}"/><joint name="j${a}" type="fixed"><parent link="l0"/><child link="x${a}"/></joint></xacro:macro>' + "".join(f'<xacro:m a="{i}"/>' for i in range(n)))),
    "xacro_dollars": ("a.xacro", 5000, lambda n: xacro(f'<xacro:property name="p" value="{"$$" * n}"/>')),
    "xacro_texts": ("a.xacro", 2000, lambda n: xacro(f'<xacro:property name="p" value="{"${1}" * n}"/>')),
    "xacro_sum": ("a.xacro", 1000, lambda n: xacro(f'<xacro:property name="p" value="${{{" + ".join(["1"] * n)}}}"/>')),
    "xacro_list": ("a.xacro", 1000, lambda n: xacro(f'<xacro:property name="p" value="${{[{", ".join(["1"] * n)}]}}"/>')),
    "xacro_ifs": ("a.xacro", 1000, lambda n: xacro('<xacro:if value="${1 == 1}"><xacro:property name="p" value="1"/></xacro:if>\n' * n)),
    "mjcf_bodies": ("a.xml", 500, lambda n: mjcf("".join(f'<body name="b{i}"><geom size="1"/></body>' for i in range(n)))),
    "mjcf_geoms": ("a.xml", 500, lambda n: mjcf("".join(f'<geom name="g{i}" size="1 1 1" type="box"/>' for i in range(n)))),
    "mjcf_joints": ("a.xml", 500, lambda n: mjcf("".join(f'<body name="b{i}"><joint name="j{i}" range="-1 1"/><geom size="1"/></body>' for i in range(n)))),
    "mjcf_sites": ("a.xml", 500, lambda n: mjcf("".join(f'<site name="s{i}"/>' for i in range(n)) + '<geom size="1"/>')),
    "mjcf_classes": ("a.xml", 500, lambda n: mjcf("".join(f'<geom class="c{i}" size="1"/>' for i in range(n)), "<default>" + "".join(f'<default class="c{i}"><geom rgba="1 0 0 1"/></default>' for i in range(n)) + "</default>")),
    "mjcf_materials": ("a.xml", 500, lambda n: mjcf("".join(f'<geom material="m{i}" size="1"/>' for i in range(n)), "<asset>" + "".join(f'<material name="m{i}" rgba="{i / n} 0 0 1"/>' for i in range(n)) + "</asset>")),
    "mjcf_meshes": ("a.xml", 250, lambda n: mjcf("".join(f'<geom type="mesh" mesh="m{i}"/>' for i in range(n)), "<asset>" + "".join(f'<mesh name="m{i}" vertex="0 0 0 1 0 0 0 1 0 0 0 {i + 1}"/>' for i in range(n)) + "</asset>")),
    "mjcf_textures": ("a.xml", 250, lambda n: mjcf('<geom size="1"/>', "<asset>" + "".join(f'<texture name="t{i}" type="2d" builtin="flat" width="1" height="1"/>' for i in range(n)) + "</asset>")),
    "mjcf_hull": ("a.xml", 2000, lambda n: mjcf('<geom type="mesh" mesh="m"/>', '<asset><mesh name="m" vertex="' + " ".join(f"{math.cos(i)} {math.sin(i)} {i % 13}" for i in range(n)) + '"/></asset>')),
    "mjcf_tendons": ("a.xml", 500, lambda n: mjcf('<body><joint name="j"/><geom size="1"/></body>', "").replace("</mujoco>", "<tendon>" + "".join(f'<fixed name="t{i}"><joint joint="j" coef="1"/></fixed>' for i in range(n)) + "</tendon></mujoco>")),
    "mjcf_excludes": ("a.xml", 500, lambda n: mjcf('<body name="a"><geom size="1"/></body><body name="b"><geom size="1"/></body>').replace("</mujoco>", "<contact>" + '<exclude body1="a" body2="b"/>' * n + "</contact></mujoco>")),
    "mjcf_equality": ("a.xml", 500, lambda n: mjcf("".join(f'<body name="b{i}"><joint name="j{i}"/><geom size="1"/></body>' for i in range(n))).replace("</mujoco>", "<equality>" + "".join(f'<joint joint1="j{i}" joint2="j{i - 1}"/>' for i in range(1, n)) + "</equality></mujoco>")),
    "mjcf_replicate": ("a.xml", 500, lambda n: mjcf(f'<replicate count="{n}" offset="1 0 0"><body name="b"><geom size="1"/></body></replicate>')),
    "sdf_models": ("a.sdf", 100, lambda n: sdf("".join(sdf_model(i, sdf_link(0)) for i in range(n)))),
    "sdf_links": ("a.sdf", 100, lambda n: sdf(sdf_model(0, "".join(sdf_link(i) for i in range(n))))),
    "sdf_visuals": ("a.sdf", 200, lambda n: sdf(sdf_model(0, sdf_link(0, n)))),
    "sdf_joints": ("a.sdf", 100, lambda n: sdf(sdf_model(0, "".join(sdf_link(i) for i in range(n)) + "".join(f'<joint name="j{i}" type="revolute"><parent>l{i - 1}</parent><child>l{i}</child><axis><xyz>0 0 1</xyz></axis></joint>' for i in range(1, n))))),
    "sdf_frames": ("a.sdf", 100, lambda n: sdf(sdf_model(0, sdf_link(0) + "".join(f'<frame name="f{i}" attached_to="{"f%d" % (i - 1) if i else "l0"}"/>' for i in range(n))))),
    "sdf_nested": ("a.sdf", 5, lambda n: sdf("".join(f'<model name="m{i}">' + sdf_link(0) for i in range(n)) + "</model>" * n)),
    "sdf_missing": ("a.sdf", 100, lambda n: sdf("".join(f"<include><uri>model://m{i}</uri></include>" for i in range(n)) + sdf_model(0, sdf_link(0)))),
    "sdf_lights": ("a.sdf", 100, lambda n: sdf("".join(f'<light name="i{i}" type="point"/>' for i in range(n)) + sdf_model(0, sdf_link(0)))),
    "adf_bodies": ("a.yaml", 200, adf),
    "adf_joints": ("a.yaml", 200, lambda n: adf(n, "chain")),
    "adf_star": ("a.yaml", 200, lambda n: adf(n, "star")),
    "adf_anchors": ("a.yaml", 500, lambda n: adf(2) + "".join(f"a{i}: &a{i} [{'*a%d' % (i - 1) if i else '1'}]\n" for i in range(n))),
    "adf_comments": ("a.yaml", 20000, lambda n: "# comment\n" * n + adf(2)),
    "mcap_messages": ("a.mcap", 50000, mcap),
    "mcap_channels": ("a.mcap", 1000, lambda n: mcap(n, channels=min(n, 65000))),
    "mcap_metadata": ("a.mcap", 5000, lambda n: mcap(1, metadata=n)),
    "mcap_schemas": ("a.mcap", 1000, lambda n: mcap(1, schemas=min(n, 65000))),
    "overlay_nodes": ("o.json", 500, lambda n: {"": overlay([{"node": f"n{i}", "visible": False} for i in range(n)]), "scene.gltf": gltf_nodes(n, {})}),
    "overlay_unknown": ("o.json", 1000, lambda n: {"": overlay([{"node": f"x{i}", "visible": False} for i in range(n)]), "scene.gltf": gltf_nodes(4, {})}),
    "overlay_lights": ("o.json", 100, lambda n: {"": overlay([{"add": f"x{i}", "light": {"type": "point", "color": [1, 1, 1], "intensity": 1.0, "casts_shadow": False}, "translation": [0, 0, 1], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]} for i in range(n)]), "scene.gltf": gltf_nodes(4, {})}),
    "overlay_materials": ("o.json", 500, lambda n: {"": overlay([{"material": f"m{i}", "base_color": [1, 0, 0, 1], "emissive": [0, 0, 0], "metallic": 0, "roughness": 1, "normal_scale": 1, "occlusion_strength": 1, "alpha_cutoff": 0.5} for i in range(n)]), "scene.gltf": gltf({"materials": [{"name": f"m{i}"} for i in range(n)], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": i} for i in range(n)]}]})}),
    "config_comments": ("fire3dv.config", 20000, lambda n: {"": "# comment\n" * n + "no-such-option = 1\n", "scene.gltf": gltf({})}),
    "config_options": ("fire3dv.config", 1000, lambda n: {"": "".join(f"stream = s{i}\n" for i in range(n)) + "no-such-option = 1\n", "scene.gltf": gltf({})}),
}


class Reader:
    def __init__(self, fire3dv, convert, inspect, folder):
        self.fire3dv, self.convert, self.inspect, self.folder = fire3dv, convert, inspect, folder

    def command(self, path):
        scene = os.path.join(self.folder, "scene.gltf")
        draws = [self.fire3dv, scene, "--headless", "--frames", "1", "--size", "16x16", "--cache", "off"]
        if path.endswith(".mcap"):
            return [self.inspect, path]
        if path.endswith(".config"):  # its last line is refused, when all are read
            return [*draws, "--config", path]
        if path.endswith(".json"):
            return [*draws, "--overlay", path]
        if path.endswith(".gltf"):
            return [self.convert, path, "--list"]
        return [self.convert, path, "-o", os.path.join(self.folder, "out.glb")]

    def seconds(self, name, make, size):
        files = make(size)
        if not isinstance(files, dict):
            files = {"": files}
        for file, contents in files.items():
            path = os.path.join(self.folder, file or name)
            with open(path, "wb") as out:
                out.write(contents if isinstance(contents, bytes) else contents.encode())
        process = subprocess.Popen(["timeout", str(HANG_S), *self.command(os.path.join(self.folder, name))], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, env={**os.environ, "FIRE3DV_CONFIG": "none"})
        said = process.stderr.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        errors = [line for line in said.decode(errors="replace").splitlines() if "error:" in line]
        return usage.ru_utime + usage.ru_stime, process.returncode, errors[0] if errors else ""


def exponent_of(reader, name, first, make):
    """Doubles the size until reading takes ENOUGH_S. Returns the exponent (None: too fast) and a line of text."""
    base = reader.seconds(name, make, 4)[0]
    times, size, said = [], first, ""
    while not times or os.path.getsize(os.path.join(reader.folder, name)) < MOST_BYTES:
        seconds, code, error = reader.seconds(name, make, size)
        if code == 124:
            return 9.0, f"size {size}: killed after {HANG_S} s"
        if error and times and "no-such" not in error and error != said:
            said = error
            if code != 0:  # a limit
                break
        said = said or error
        times.append((size, max(seconds - base, 1e-3)))
        if times[-1][1] >= ENOUGH_S:
            break
        size *= 2
    if len(times) < 3 or times[-1][1] < LEAST_S:
        return None, f"size {times[-1][0] if times else 0}: {times[-1][1] if times else 0:.2f} s {said[:160]}"
    (small, before), (large, after) = times[-3], times[-1]
    exponent = math.log(after / before) / math.log(large / small)
    return exponent, f"size {large}: {after:.2f} s, exponent {exponent:.2f} {said[:160]}"


def main():
    arguments = [each for each in sys.argv[1:] if each != "--report"]
    names = arguments[3:] or list(CASES)
    failed = []
    with tempfile.TemporaryDirectory(prefix="reader_times.") as folder:
        reader = Reader(*(os.path.abspath(each) for each in arguments[:3]), folder)
        for case in names:
            name, first, make = CASES[case]
            exponent, text = exponent_of(reader, name, first, make)
            if exponent is not None and exponent > MOST_EXPONENT:
                exponent, text = min((exponent, text), exponent_of(reader, name, first, make), key=lambda each: each[0] or 0)
            is_slow = exponent is not None and exponent > MOST_EXPONENT
            print(f"{'SLOW' if is_slow else 'ok'} {case}: {text}", flush=True)
            failed += [case] if is_slow else []
    if failed and "--report" not in sys.argv:
        sys.exit(f"readers whose time grows with an exponent above {MOST_EXPONENT}: {', '.join(failed)}")


main()
