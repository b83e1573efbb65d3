"""Conformance test of the Python package against the golden messages: the package sends each message, and the receiver
decodes its JSON. Invalid messages are refused with the name of the same field.

python_conformance_test.py STREAM_DUMP FOLDER_OF_GOLDEN_MESSAGES

Golden messages that no client can send are listed below with the reason, so that each new one must be classified here.
"""
import glob
import json
import math
import os
import sys

import numpy as np

import fire3dv
from stream_lines import StreamLines

NAN, INF = math.nan, math.inf


def pose(x):
    return [0, 0, 1, x, 0, 1, 0, -0.5, -1, 0, 0, 2.25]


def golden():
    """name -> meaning"""
    result = {}
    for path in glob.glob(os.path.join(sys.argv[2], "*.json")):
        with open(path, encoding="utf-8") as file:
            result[os.path.basename(path)[:-5]] = json.load(file)
    assert len(result) >= 50, f"golden messages are missing from {sys.argv[2]}"
    return result


# --- messages that the package can send ------------------------------------------------------------------------------

NOT_SAID = {
    "pose_frame-part": "the library cuts frames by itself",
    "pose_frame-all_header_fields": "numbers of the header are the library's",
    "stream_description-later_minor": "the library says its own version",
    "scene_edit-marker_of_later_version": "the library knows its own kinds",
    "stream_description-minor_1": "is one without an adapter's nodes, as stream_description-no_nodes",
}
OWN = {"epoch", "clock", "protocol_minor", "sequence", "publish_time_ns", "scene_version", "version"}  # set by the library


def pixels_of(image):
    if image is None:
        return None
    return np.array(image["pixels"], np.uint8).reshape(image["height"], image["width"], image["channels"])


def same(name, came, meant):
    for key, value in meant.items():
        if key not in OWN:
            assert came[key] == value, f"{name}: {key} came as {came[key]}, not {value}"


def say_description(stream, lines, name, meant):
    stream.describe(meant["node_names"], np.array(meant["world_from_stream"]),
                    np.array(meant["body_from_node"], np.float32).reshape(-1, 3, 4), meant["nominal_rate_hz"],
                    meant["scene_uri"])
    epoch = stream.poll().epoch
    same(name, lines.wait_for(name, lambda m: m["type"] == "StreamDescription" and m["epoch"] == epoch), meant)


def say_frame(stream, lines, name, meant):
    stream.describe([f"node {i}" for i in range(meant["node_count"])])
    poses = np.array(meant["poses"], np.float32).reshape(-1, 3, 4)
    if "node_indices" in meant:  # needs a preceding frame with all nodes
        everywhere = np.tile(np.eye(3, 4, dtype=np.float32), (meant["node_count"], 1, 1))
        lines.frame(stream.poll().epoch, stream.publish_some(0, np.arange(meant["node_count"]), everywhere))
        sequence = stream.publish_some(meant["sim_time_ns"], np.array(meant["node_indices"]), poses, meant["flags"])
    else:
        sequence = stream.publish(meant["sim_time_ns"], poses, meant["flags"])
    same(name, lines.frame(stream.poll().epoch, sequence), meant)


def say_edit(stream, lines, name, meant):
    node, value = meant["node"], meant["value"]
    before = len(lines.messages)
    kind = value["type"]
    if meant["property"] in ("scalars", "scalar_values"):
        return say_scalars(stream, lines, name, meant)
    if meant["property"] == "input":
        return say_input(stream, lines, name, meant)
    if kind == "Cleared":
        stream.clear(node, fire3dv.Property[meant["property"].upper()])
    elif kind == "Visible":
        stream.set_visible(node, value["visible"])
    elif kind == "BaseColor":
        stream.set_base_color(node, np.array(value["rgba"], np.float32))
    elif kind == "Light":
        stream.set_light(node, **{key: value[key] for key in value if key != "type"})
    elif kind == "Camera":
        stream.set_camera(node, **{key: value[key] for key in value if key != "type"})
    elif kind == "NodeAdded":
        stream.add_node(node, value["parent"], np.array(value["parent_from_node"]), value["asset_uri"] or None,
                        bytes(value["asset_glb"]) or None, value["variant"] or None)
    elif kind == "NodeRemoved":
        stream.remove_node(node)
    elif kind == "Marker":
        if value["lifetime_ns"]:  # counts from the frame published last
            stream.describe([])
            stream.publish(value["sim_time_ns"], [])
        width = {("width_px", "width_m")[value["width_unit"]]: value["width"]}
        stream.set_marker(node, value["kind"], np.array(value["positions"], np.float32).reshape(-1, 3),
                          rotations=np.array(value["rotations"], np.float32).reshape(-1, 4),
                          sizes=np.array(value["sizes"], np.float32).reshape(-1, 3),
                          colors=np.array(value["colors"], "<u4").view(np.uint8).reshape(-1, 4),
                          parent=value["parent"], parent_from_marker=np.array(value["parent_from_marker"]),
                          lifetime_s=value["lifetime_ns"] / 1e9, overlaid=value["flags"] == 1,
                          texts=value.get("texts"), pixels=pixels_of(value.get("image")), **width)
    else:
        assert kind == "Vertices", f"{name}: nothing here sets {kind}"
        normals = np.array(value["normals"]) if value["normals"] else None
        stream.set_vertices(node, np.array(value["positions"]), normals)
    stream.poll()
    same(name, lines.wait_for(name, lambda m: m["type"] == "SceneEdit" and m["value"] == value and
                              m in lines.messages[before:]), meant)


def say_scalars(stream, lines, name, meant):
    group, value = meant["node"], dict(meant["value"])
    before = len(lines.messages)
    stream.declare_scalars(group, value.get("names", ["a", "b", "c"]), value.get("units"))
    if value["type"] == "ScalarValues":
        stream.set_scalars(group, value["sim_time_ns"], [NAN if number is None else number for number in value["values"]])
        value.pop("declaration")  # a version, which the library sets
    elif value["type"] == "Cleared":
        stream.set_scalars(group, 0, [0, 0, 0])
        stream.clear_scalars(group)
    stream.poll()
    came = lines.wait_for(name, lambda m: m["type"] == "SceneEdit" and m["property"] == meant["property"] and
                          value.items() <= m["value"].items() and m in lines.messages[before:])
    same(name, {**came, "value": {**came["value"], **meant["value"]}}, meant)


def say_input(stream, lines, name, meant):
    control, value = meant["node"], meant["value"]
    before = len(lines.messages)
    controls = stream.controls
    declare = [
        lambda: controls.slider(control, value["minimum"], value["maximum"], value["value"], value["step"], value["unit"]),
        lambda: controls.button(control),
        lambda: controls.toggle(control, bool(value["value"])),
        lambda: controls.choice(control, value["choices"], value["choices"][int(value["value"])]),
        lambda: controls.text(control, value["text"]),
        lambda: controls.run(control, bool(value["value"]), (value["minimum"], value["maximum"]), value["speed"]),
        lambda: controls.drag(control, value["value"])]
    if value["type"] == "Cleared":
        controls.button(control).remove()
    else:
        declare[value["kind"]]()
    stream.poll()
    came = lines.wait_for(name, lambda m: m["type"] == "SceneEdit" and m["property"] == "input" and m["node"] == control and
                          m["value"]["type"] == value["type"] and m in lines.messages[before:])
    same(name, came, meant)


# --- refused calls ---------------------------------------------------------------------------------------------------

FULL = {"node_names": ["base", "arm", "robot/link 1", "Körper", "🤖"], "world_from_stream": np.eye(3, 4),
        "body_from_node": [pose(i) for i in range(5)], "nominal_rate_hz": 240, "scene_uri": "file:scene.glb"}


def described(**changed):
    return lambda stream: stream.describe(**{**FULL, **changed})


def named(index, name):
    return described(node_names=[name if i == index else other for i, other in enumerate(FULL["node_names"])])


def framed(*poses):
    return lambda stream: stream.publish(0, [list(p) for p in poses])


def some(*indices):
    return lambda stream: stream.publish_some(0, list(indices), [pose(0)] * 2)


def changed(numbers, index, value):
    return [value if i == index else number for i, number in enumerate(numbers)]


def lit(**changes):
    values = {"kind": fire3dv.SPOT, "color_rgb": (1, 0.5, 0.25), "intensity": 800, "range_m": 12.5,
              "inner_cone_rad": 0.25, "outer_cone_rad": 0.5}
    return lambda stream: stream.set_light("lamp", **{**values, **changes})


def seen(**changes):
    values = {"vertical_fov_rad": 0.75, "near_m": 0.1, "far_m": 100}
    return lambda stream: stream.set_camera("eye", **{**values, **changes})


POINTS = [[0, 0, 0], [1, -2.5, 1e6], [0.5, 0, 3]]


def marked(kind="POINTS", **changes):
    values = {"positions": POINTS, "colors": (1, 0, 0)}
    if kind == "BOXES":
        values.update(positions=POINTS[:2], sizes=[0.1, 0.2, 0.3], rotations=[[0, 0, 0, 1], [0, 0, 0.6, 0.8]])
    return lambda stream: stream.set_marker("contacts/foot", fire3dv.MarkerKind[kind], **{**values, **changes})


def texted(*texts):
    return marked("TEXTS", positions=POINTS[:2], texts=list(texts))


def imaged(width=3, height=2, channels=4, **changes):
    return marked("IMAGES", positions=POINTS[:1], pixels=np.zeros((height, width, channels), np.uint8),
                  **{"sizes": [1, 1, 0], "colors": None, **changes})


def declared(*names):
    return lambda stream: stream.declare_scalars("arm", names)


NO_CLIENT_SAYS_IT = "numbers of the header are the library's"
NO_TEXT = "is no str of Python, which raises before the library is asked"
# name without "refused-": a call that must be refused and a part of its error message, or why no call sends
# it
REFUSED = {
    "description_adapter_name_newline": (lambda _: fire3dv.Stream("shm://x", adapter_name="a\nb"), "adapter_name"),
    "description_body_from_node_count": (described(body_from_node=[pose(i) for i in range(4)]), "body_from_node"),
    "description_body_from_node_infinite": (
        described(body_from_node=[pose(0), pose(1), changed(pose(2), 6, INF), pose(3), pose(4)]),
        "body_from_node[2] row 1"),
    "description_boot_id_tab": NO_CLIENT_SAYS_IT,
    "description_epoch_zero": NO_CLIENT_SAYS_IT,
    "description_name_c1_control": (named(2, "a\x9b31m"), "node_names[2]"),
    "description_name_control_character": (named(2, "\x1b[2Jgone"), "node_names[2]"),
    "description_name_cut_utf8": NO_TEXT,
    "description_name_empty": (named(1, ""), "node_names[1]"),
    "description_name_nul": (named(2, "a\0b"), "node_names[2]"),
    "description_name_overlong_utf8": NO_TEXT,
    "description_name_surrogate": (named(0, "\ud800"), "node_names[0]"),
    "description_name_too_long": (named(3, "x" * 1025), "node_names[3]"),
    "description_name_turns_direction": (named(2, "\u202egnp.exe"), "node_names[2]"),
    "description_name_twice": (named(4, "base"), "node_names[4]"),
    "description_rate_nan": (described(nominal_rate_hz=NAN), "nominal_rate_hz"),
    "description_rate_negative": (described(nominal_rate_hz=-1), "nominal_rate_hz"),
    "description_sim_rate_infinite": NO_CLIENT_SAYS_IT,
    "description_uri_too_long": (described(scene_uri="x" * 4097), "scene_uri"),
    "description_world_huge": (described(world_from_stream=changed(pose(0), 0, 1e300)), "world_from_stream[0]"),
    "description_world_nan": (described(world_from_stream=changed(pose(0), 11, NAN)), "world_from_stream[11]"),
    "pose_frame_epoch_zero": NO_CLIENT_SAYS_IT,
    "pose_frame_first_node_too_large": "the library cuts frames by itself",
    "pose_frame_first_node_wraps": "the library cuts frames by itself",
    "pose_frame_huge": (framed(changed(pose(0), 5, 1.1e12), pose(0)), "[0] row 1 column 1"),
    "pose_frame_infinite": (framed(changed(pose(0), 5, -INF), pose(0)), "[0] row 1 column 1 is -infinity"),
    "pose_frame_more_poses_than_nodes": (framed(pose(0), pose(1), pose(2)), "stream_from_body has 3 poses"),
    "pose_frame_nan": (framed(pose(0), changed(pose(0), 5, NAN)), "[1] row 1 column 1 is NaN"),
    "pose_frame_partial": "no table of a later version comes from a client",
    "pose_frame_partial_count": (lambda stream: stream.publish_some(0, [1], [pose(0)] * 2), "1 node_indices"),
    "pose_frame_partial_falling": (some(1, 0), "node_indices[1]"),
    "pose_frame_partial_outside": (some(1, 2), "node_indices[1]"),
    "pose_frame_partial_twice": (some(1, 1), "node_indices[1]"),
    "pose_frame_sequence_zero": NO_CLIENT_SAYS_IT,
    "pose_frame_too_many_nodes": "takes more names than a test should hold",
    "scene_edit_variant_without_asset": (lambda s: s.add_node("a", variant="red"), "variant"),
    "scene_edit_asset_twice": (lambda s: s.add_node("a", asset_uri="a.glb", asset_glb=b"\1"), "asset_uri"),
    "scene_edit_camera_exposure_negative": (seen(exposure=-1), "exposure"),
    "scene_edit_camera_far_before_near": (seen(far_m=0.1), "far_m"),
    "scene_edit_camera_fov_nan": (seen(vertical_fov_rad=NAN), "vertical_fov_rad"),
    "scene_edit_camera_fov_zero": (seen(vertical_fov_rad=0), "vertical_fov_rad"),
    "scene_edit_camera_lens_f_number_large": (seen(f_number=1e9, focus_distance_m=2), "f_number"),
    "scene_edit_camera_lens_f_number_nan": (seen(f_number=NAN, focus_distance_m=2), "f_number"),
    "scene_edit_camera_lens_f_number_small": (seen(f_number=0.01, focus_distance_m=2), "f_number"),
    "scene_edit_camera_lens_focus_infinite": (seen(f_number=2.8, focus_distance_m=INF), "focus_distance_m"),
    "scene_edit_camera_lens_focus_negative": (seen(f_number=2.8, focus_distance_m=-1), "focus_distance_m"),
    "scene_edit_camera_lens_without_f_number": (seen(focus_distance_m=2), "f_number is 0"),
    "scene_edit_camera_lens_without_focus": (seen(f_number=2.8), "focus_distance_m is 0"),
    "scene_edit_camera_near_zero": (seen(near_m=0), "near_m"),
    "scene_edit_color_above_one": (lambda s: s.set_base_color("a", [0, 0, 0, 1.5]), "rgba[3]"),
    "scene_edit_color_nan": (lambda s: s.set_base_color("a", [0, NAN, 0, 1]), "rgba[1]"),
    "scene_edit_epoch_zero": NO_CLIENT_SAYS_IT,
    "scene_edit_light_color_infinite": (lit(color_rgb=(1, 1, INF)), "color_rgb[2]"),
    "scene_edit_light_cones": (lit(inner_cone_rad=0.5), "inner_cone_rad"),
    "scene_edit_light_kind": (lit(kind=3), "kind"),
    "scene_edit_light_negative": (lit(intensity=-1), "intensity"),
    "scene_edit_light_wide": (lit(outer_cone_rad=2), "outer_cone_rad"),
    "scene_edit_marker_colors_count": (marked(colors=[(1, 0, 0)] * 2), "colors has 2"),
    "scene_edit_marker_image_channels": (imaged(channels=2), "the shape (2, 3, 2)"),
    "scene_edit_marker_image_colors": (imaged(colors=(1, 0, 0)), "colors is given"),
    "scene_edit_marker_image_none": (marked("IMAGES", sizes=[1, 1, 0], colors=None), "image has 0 x 0"),
    "scene_edit_marker_image_of_points": (marked(pixels=np.zeros((2, 3), np.uint8)), "image is given"),
    "scene_edit_marker_image_pixels_few": "arrays have as many pixels as their shape says",
    "scene_edit_marker_image_pixels_many": "arrays have as many pixels as their shape says",
    "scene_edit_marker_image_side_overflow": "no array has that many pixels",
    "scene_edit_marker_image_sizes_nan": (imaged(sizes=[1, NAN, 0]), "sizes[0][1]"),
    "scene_edit_marker_image_sizes_none": (imaged(sizes=None), "sizes has 0"),
    "scene_edit_marker_image_too_wide": (imaged(width=1025), "1025 x 2"),
    "scene_edit_marker_later_kind_rotation_nan": "the library knows its own kinds",
    "scene_edit_marker_name_empty": (lambda s: s.points("", POINTS), "node"),
    "scene_edit_marker_of_other_property": "a call sets the value of its property",
    "scene_edit_marker_parent_newline": (marked(parent="a\nb"), "parent"),
    "scene_edit_marker_pose_infinite": (marked(parent_from_marker=changed(pose(0), 11, INF)), "parent_from_marker"),
    "scene_edit_marker_positions_nan": (marked(positions=[[0, 0, 0], [0, 0, NAN]]), "positions[1][2]"),
    "scene_edit_marker_positions_not_triples": (marked("TRIANGLES", positions=POINTS[:2]), "positions of triangles"),
    "scene_edit_marker_positions_odd": (marked("LINES"), "positions of lines"),
    "scene_edit_marker_positions_one": (marked("LINE_STRIP", positions=POINTS[:1]), "positions of line_strip"),
    "scene_edit_marker_rotation_nan": (marked("BOXES", rotations=[0, 0, 0, NAN]), "rotations[0][3]"),
    "scene_edit_marker_rotation_zero": (marked("BOXES", rotations=[[0, 0, 0, 1], [0] * 4]), "rotations[1]"),
    "scene_edit_marker_rotations_count": (marked("BOXES", rotations=[[0, 0, 0, 1]] * 3), "rotations has 3"),
    "scene_edit_marker_rotations_of_points": (marked(rotations=[0, 0, 0, 1]), "rotations"),
    "scene_edit_marker_sizes_nan": (marked("BOXES", sizes=[1, 1, NAN]), "sizes[0][2]"),
    "scene_edit_marker_sizes_negative": (marked("BOXES", sizes=[1, -1, 1]), "sizes[0][1]"),
    "scene_edit_marker_sizes_none": (marked("BOXES", sizes=None), "sizes has 0"),
    "scene_edit_marker_sizes_of_points": (marked(sizes=[1, 1, 1]), "sizes"),
    "scene_edit_marker_texts_count": (texted("a"), "texts has 1"),
    "scene_edit_marker_texts_invalid_utf8": NO_TEXT,
    "scene_edit_marker_texts_of_points": (marked(texts=["a", "b", "c"]), "texts is given"),
    "scene_edit_marker_texts_right_to_left_override": (texted("a\u202eb", "c"), "texts[0]"),
    "scene_edit_marker_texts_tab": (texted("a", "a\tb"), "texts[1]"),
    "scene_edit_marker_texts_too_long": (texted("a", "x" * 1025), "texts[1]"),
    "scene_edit_marker_unit": "the package names units by argument",
    "scene_edit_marker_width_nan": (marked(width_px=NAN), "width"),
    "scene_edit_marker_width_negative": (marked(width_m=-1), "width"),
    "scene_edit_node_control_character": (lambda s: s.remove_node("\x1b[2J"), "node"),
    "scene_edit_node_empty": (lambda s: s.remove_node(""), "node"),
    "scene_edit_node_too_long": (lambda s: s.remove_node("x" * 1025), "node"),
    "scene_edit_normals_count": (lambda s: s.set_vertices("a", [[0, 0, 0]], [[0, 0, 1]] * 2), "normals"),
    "scene_edit_parent_from_node_nan": (lambda s: s.add_node("a", parent_from_node=changed(pose(0), 0, NAN)),
                                        "parent_from_node"),
    "scene_edit_parent_newline": (lambda s: s.add_node("a", parent="a\nb"), "parent"),
    "scene_edit_input_choice_empty": (lambda s: s.controls.choice("m", ["", "b"]), "choices[0] is empty"),
    "scene_edit_input_choice_fraction": "an index, which the package makes",
    "scene_edit_input_choice_repeated": (lambda s: s.controls.choice("m", ["a", "a"]), "choices[1] repeats"),
    "scene_edit_input_choices_none": (lambda s: s.controls.choice("m", []), "choices is empty"),
    "scene_edit_input_choices_of_slider": "a slider of the package has none",
    "scene_edit_input_choices_too_many": (lambda s: s.controls.choice("m", map(str, range(257))), "at most 256"),
    "scene_edit_input_name_empty": (lambda s: s.controls.button(""), "node is empty"),
    "scene_edit_input_name_too_long": (lambda s: s.controls.button("x" * 128), "node has 128"),
    "scene_edit_input_range_empty": (lambda s: s.controls.slider("g", -1, -1), "maximum is -1"),
    "scene_edit_input_range_infinite": (lambda s: s.controls.slider("g", -1, INF), "maximum is inf"),
    "scene_edit_input_run_half": "a bool, which is 0 or 1",
    "scene_edit_input_run_takes_nothing": (
        lambda s: s.controls.run(can_pause=False, can_step=False, can_reset=False), "flags is 0"),
    "scene_edit_input_speed_negative": (lambda s: s.controls.run(speeds=(-1, 4)), "minimum is -1"),
    "scene_edit_input_speed_outside": (lambda s: s.controls.run(speeds=(0, 4), speed=5), "speed is 5"),
    "scene_edit_input_step_negative": (lambda s: s.controls.slider("g", 0, 1, step=-1), "step is -1"),
    "scene_edit_input_stiffness_negative": (lambda s: s.controls.drag(stiffness=-1), "value is -1"),
    "scene_edit_input_text_too_long": (lambda s: s.controls.text("n", "x" * 1024), "text has 1024"),
    "scene_edit_input_toggle_two": "a bool, which is 0 or 1",
    "scene_edit_input_unit_escape": (lambda s: s.controls.slider("g", 0, 1, unit="\x1b[2J"), "unit holds a control"),
    "scene_edit_input_unit_too_long": (lambda s: s.controls.slider("g", 0, 1, unit="x" * 64), "unit has 64"),
    "scene_edit_input_value_nan": (lambda s: s.controls.slider("g", 0, 1, NAN), "value is nan"),
    "scene_edit_input_value_outside": (lambda s: s.controls.slider("g", 0, 1, 3), "value is 3"),
    "scene_edit_scalar_values_declaration_zero": "a version, which the library sets",
    "scene_edit_scalar_values_none": (lambda s: s.scalars("arm", 0, {}), "values is empty"),
    "scene_edit_scalar_values_too_many": "values are as many as the declaration has",
    "scene_edit_scalars_group_empty": (lambda s: s.declare_scalars("", ["a"]), "node is empty"),
    "scene_edit_scalars_name_cut_utf8": NO_TEXT,
    "scene_edit_scalars_name_empty": (declared("a", ""), "names[1]"),
    "scene_edit_scalars_name_newline": (declared("a\nb"), "names[0]"),
    "scene_edit_scalars_name_repeated": (declared("a", "b", "a"), "names[2] repeats"),
    "scene_edit_scalars_name_too_long": (declared("a", "b", "x" * 1025), "names[2]"),
    "scene_edit_scalars_none": (declared(), "names"),
    "scene_edit_scalars_of_other_property": "a call sets the value of its property",
    "scene_edit_scalars_too_many": "is over the budget of a stream, an error of another type",
    "scene_edit_scalars_unit_escape": (lambda s: s.declare_scalars("arm", ["a"], ["\x1b[2J"]), "units[0]"),
    "scene_edit_scalars_unit_too_long": (lambda s: s.scalars("arm", 0, {"a": 1}, {"a": "x" * 65}), "units[0]"),
    "scene_edit_scalars_units_count": (lambda s: s.declare_scalars("arm", ["a", "b"], ["m"]), "1 units for 2 names"),
    "scene_edit_value_of_other_property": "a call sets the value of its property",
    "scene_edit_version_zero": NO_CLIENT_SAYS_IT,
    "scene_edit_vertices_nan": (lambda s: s.set_vertices("a", [[0, 0, 0], [0, NAN, 0]]), "positions[1][1]"),
    "scene_edit_vertices_none": (lambda s: s.set_vertices("a", []), "positions"),
}


def main():
    lines = StreamLines(sys.argv[1], "tcp://127.0.0.1:0")  # partial frames stay partial over tcp
    say = {"StreamDescription": say_description, "PoseFrame": say_frame, "SceneEdit": say_edit}
    said = refused = 0
    with fire3dv.Stream(lines.uri, adapter_name="conformance") as stream:
        stream.describe([])
        while not stream.poll().renderers:
            pass
        for name, meaning in sorted(golden().items()):
            meant = meaning.get("message", {})
            if meant.get("type") in say and not name.startswith("later-") and name not in NOT_SAID:
                say[meant["type"]](stream, lines, name, meant)
                said += 1
        stream.describe(["base", "arm"])
        stream.publish_some(0, [0, 1], [pose(0), pose(1)])
        before = stream.poll()
        for name in sorted(golden()):
            if not name.startswith("refused-") or name.startswith(("refused-welcome", "refused-status", "refused-image", "refused-input_event")):
                continue
            case = REFUSED.get(name[len("refused-"):])
            assert case, f"{name} is new: say it here"
            if isinstance(case, str):
                continue
            call, text = case
            try:
                call(stream)
            except fire3dv.ArgumentError as error:
                assert text in str(error) and "\n" not in str(error), f"{name}: {error}"
            else:
                raise AssertionError(f"{name} was not refused")
            refused += 1
        after = stream.poll()
        assert (after.epoch, after.sequence) == (before.epoch, before.sequence), "what was refused changed the stream"
    lines.end()
    assert said >= 17 and refused >= 45, (said, refused)
    print(f"{said} said, {refused} refused")


main()
