#!/usr/bin/env python3
"""End-to-end test of offline rendering: identical bytes from a cold start, in shards, after a kill, and from the live run."""
import json
import os
import shutil
import signal
import subprocess

from glb_edit import add_variants, edit_glb
from harness import HANG_S, PLAIN_IMAGES, Program, check, main, shown, vulkan_environment, wait_until
from image_reader import PLACE_AT_REST, SQUARES, read_png, write_scene

SIZE = "160x90"
FRAMES = 40  # of the recording at FPS: 60 frames of 10 ms, then 20 more, first to last
FPS = 50


def recording(test, attach=False):
    path = test.path("attached.mcap" if attach else "made.mcap")
    if not os.path.exists(path):
        done = subprocess.run([test.programs_at["make"], path, test.scene, *(["attach"] if attach else [])],
                              capture_output=True, text=True, timeout=HANG_S)
        check(done.returncode == 0, f"no recording: {done.stderr}")
    return path


def command_of(test, file, out, *arguments, scene=True, look=PLAIN_IMAGES):
    """look: options of quality; () for the default: four samples, shadows by maps and rays."""
    return [test.programs_at["fire3dv"], "render", file, *([test.scene] if scene else []), "--out", out, "--validation",
            "--cache", "off", "--tone-map", "none", "--size", SIZE, *look, *map(str, arguments)]


def start(test, file, out, *arguments, **options):
    return Program(test, "render", command_of(test, file, out, *arguments, **options), vulkan_environment())


def render(test, file, out, *arguments, code=0, **options):
    program = start(test, file, out, *arguments, **options)
    program.expect_exit(code)
    return program.stderr_text()


def join(test, *arguments, code=0):
    program = Program(test, "join", [test.programs_at["fire3dv"], "join", *map(str, arguments)], vulkan_environment())
    program.expect_exit(code)
    return program.stderr_text()


def files_of(folder):
    """Returns all files except for the manifest, which names the renderer and the shard."""
    return {name: open(os.path.join(folder, name), "rb").read() for name in sorted(os.listdir(folder)) if name != "manifest.json"}


def lines_of(path):
    with open(path, encoding="utf-8") as file:
        return [json.loads(line) for line in file]


def pixels_of(folder, line):
    return read_png(os.path.join(folder, line["file"])).rows


def has_green(picture):
    return any(row[i + 1] > 200 and row[i] < 60 and row[i + 2] < 60 for row in picture.rows for i in range(0, len(row), 3))


def whole_run(test):
    """Renders all frames in one run: the reference for the other runs."""
    folder = os.path.join(test.folder, "whole")
    if not os.path.exists(folder):
        render(test, recording(test), folder, "--fps", FPS)
    return folder


def frames_are_right(test):
    folder = whole_run(test)
    lines = lines_of(os.path.join(folder, "frames.jsonl"))
    check([line["frame"] for line in lines] == list(range(FRAMES)), f"not each frame once: {[line['frame'] for line in lines]}")
    arms = [shown(line, "arm") for line in lines]
    for line, arm in zip(lines, arms):
        at_ms = 10 + 20 * line["frame"]
        if at_ms <= 600:
            check(arm["epoch"] == "0000000000000011" and arm["sim_time_ns"] == at_ms * 10**6 and arm["sequence"] == at_ms // 10, f"{line}")
        elif at_ms >= 610 and arm:
            check(arm["epoch"] == "0000000000000022" and arm["sim_time_ns"] == (at_ms - 600) * 10**6, f"{line}")
        check((shown(line, "crane") is not None) == (at_ms >= 120), f"the crane's begin: {line}")
    check(all(arms), f"frames without the arm: {[i for i, arm in enumerate(arms) if not arm]}")
    pictures = [read_png(os.path.join(folder, line["file"])) for line in lines]
    check(len({b"".join(bytes(row) for row in picture.rows) for picture in pictures}) >= FRAMES - 2, "frames look alike")
    # Green is hidden from frame 20 (200 ms) to 50; the added asset contains a green square and exists from 25
    # to 40.
    for line, picture in zip(lines, pictures):
        at_ms = 10 + 20 * line["frame"]
        hidden = 200 <= at_ms < 500 and not 250 <= at_ms < 400
        check(has_green(picture) != hidden, f"green at {at_ms} ms: {has_green(picture)}")


def a_cold_start_changes_nothing(test):
    folder = whole_run(test)
    lines = lines_of(os.path.join(folder, "frames.jsonl"))
    # 30 to 33: the asset node exists, and nodes are hidden. The edits precede these frames, so none of them
    # draws the transition.
    row, full = test.path("row"), {"look": ()}
    render(test, recording(test), row, "--fps", FPS, "--start", 7 / FPS, "--end", 9 / FPS, **full)
    for first, last, options in ((9, 9, full), (14, 17, {}), (32, 33, {})):
        out = test.path(f"alone{first}")
        render(test, recording(test), out, "--fps", FPS, "--start", first / FPS, "--end", last / FPS, **options)
        alone = lines_of(os.path.join(out, "frames.jsonl"))
        check(len(alone) == last - first + 1, f"{len(alone)} frames from {first} to {last}")
        for line in alone:
            wanted = lines[first + line["frame"]]
            check(line["streams"] == wanted["streams"], f"{line} is not {wanted}")
            same = pixels_of(row, lines_of(os.path.join(row, "frames.jsonl"))[2]) if options else pixels_of(folder, wanted)
            check(pixels_of(out, line) == same, f"frame {wanted['frame']} drawn alone is another picture")


def paths_are_traced(test):
    """A path-traced frame depends on its own moment alone, and its file names the settings."""
    path = ("--fps", FPS, "--render", "path", "--spp", 1, "--bounces", 1, "--seed", 3)
    row, alone = test.path("row"), test.path("alone")
    render(test, recording(test), row, *path, "--start", 20 / FPS, "--end", 21 / FPS, look=())
    render(test, recording(test), alone, *path, "--start", 21 / FPS, "--end", 21 / FPS, look=())
    lines, (line,) = lines_of(os.path.join(row, "frames.jsonl")), lines_of(os.path.join(alone, "frames.jsonl"))
    check(len(lines) == 2 and line["streams"] == lines[1]["streams"], f"{lines}, {line}")
    check((line["renderer"], line["samples_per_pixel"], line["bounces"], line["seed"]) == ("path", 1, 1, 3), line)
    check(pixels_of(alone, line) == pixels_of(row, lines[1]), "a frame drawn alone is another picture")
    check(pixels_of(row, lines[0]) != pixels_of(row, lines[1]), "nothing moves")


def a_killed_path_is_gone_on_with(test):
    """A frame that was being path-traced goes on from its checkpoint to the same bytes."""
    path = ("--fps", FPS, "--render", "path", "--spp", 24, "--bounces", 1, "--start", 20 / FPS, "--end", 21 / FPS)
    out, whole = test.path("killed paths"), test.path("whole paths")
    file = os.path.join(out, "paths.checkpoint")
    program = start(test, recording(test), out, *path, "--checkpoint", 0.001, look=())
    wait_until(lambda: f"a checkpoint; it said:\n{program.stderr_text()}",
               lambda: os.path.exists(file) or not program.alive())
    program.kill()
    check(os.path.exists(file), "the run ended before the kill")
    said = render(test, recording(test), out, *path, look=())
    check("info: going on after " in said and " of 24 samples per pixel" in said, said)
    render(test, recording(test), whole, *path, look=())
    check(files_of(out) == files_of(whole), "what was gone on with is other bytes than a single run")


def an_overlay_is_applied(test):
    """The edits and additions of --overlay hold in every frame, and the manifest names them."""
    overlay, plain, edited = test.path("edits.json"), test.path("plain"), test.path("edited")
    with open(overlay, "w", encoding="ascii") as file:
        place = '"rotation": [0, 0, 0, 1], "scale": [1, 1, 1]'
        file.write('{"fire3dv_overlay": {"version": 2, "edits": [{"node": "mine", "translation": [5, 0, 50], '
                   f'{place}}}, {{"add": "mine", "copy": "front", "translation": [0, 0, 50], {place}}}, '
                   '{"add": "part", "asset": "part.gltf"}, {"material": "steel", "of": "part", "base_color": [1, 0, 0, 1], '
                   '"emissive": [0, 0, 0], "metallic": 0, "roughness": 1, "normal_scale": 1, "occlusion_strength": 1, '
                   '"alpha_cutoff": 0.5}]}}')
    with open(test.path("part.gltf"), "w", encoding="ascii") as file:
        file.write('{"asset": {"version": "2.0"}, "materials": [{"name": "steel"}], "nodes": [{"name": "empty"}], '
                   '"scenes": [{"nodes": [0]}]}')
    part = ("--fps", FPS, "--start", 20 / FPS, "--end", 21 / FPS)
    render(test, recording(test), plain, *part)
    said = render(test, recording(test), edited, *part, "--overlay", overlay, "--camera", "mine")
    check("no effect" not in said and "not added" not in said, said)
    lines = lines_of(os.path.join(plain, "frames.jsonl"))
    with_overlay = lines_of(os.path.join(edited, "frames.jsonl"))
    check(len(lines) == 2 and with_overlay == [{**line, "camera": "mine"} for line in lines], f"{lines} {with_overlay}")
    for line in lines:
        before, after = (read_png(os.path.join(folder, line["file"])) for folder in (plain, edited))
        places = [(before.place_of_square(name), after.place_of_square(name)) for name in ("red", "green", "blue")]
        seen = [(at, moved) for at, moved in places if at is not None and moved is not None]
        check(seen and all(abs(at - 5 - moved) < 0.6 for at, moved in seen), f"without the edits, and with them: {places}")
    with open(os.path.join(edited, "manifest.json"), encoding="utf-8") as file:
        check("overlay" in file.read(), "the manifest does not name the edits")


def joints_are_moved(test):
    """Joint positions of --overlay move the body that no stream drives, and its variant is chosen, to the bytes of a headless
    replay.
    """
    scene, overlay, out = test.path("robot.glb"), test.path("joints.json"), test.path("joints")
    write_scene(scene, squares={**SQUARES, "yellow": ((1, 1, 0), -30)})

    def add_robot(document, binary):
        axes = {"red": "driven", "yellow": "slide"}
        robot = {"version": 1, "bodies": [{"node": body, "translation": [PLACE_AT_REST, 0, 0]} for body in axes],
                 "joints": [{"name": joint, "type": "prismatic", "node": body, "axis": [1, 0, 0]} for body, joint in axes.items()]}
        document["nodes"].append({"name": "robot", "extras": {"fire3dv": {"robot": robot}}})
        document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
        return binary
    add_variants(edit_glb(scene, scene, add_robot), scene, {"fire": "red", "night": "green"})
    slide = -40
    # Blue has another simulator, whose poses a frame of this one's time lies between.
    with open(overlay, "w", encoding="ascii") as file:
        file.write('{"fire3dv_overlay": {"version": 1, "edits": [{"node": "blue", "visible": false}, {"variant": "night"}, '
                   '{"joint": "driven", "position": [30]}, {"joint": "slide", "position": [%d]}]}}' % slide)
    command = command_of(test, recording(test), out, "--overlay", overlay, "--fps", FPS, "--start", 20 / FPS, "--end", 21 / FPS,
                         "--ground", "off", scene=False)
    command.insert(3, scene)
    program = Program(test, "render", command, vulkan_environment())
    program.expect_exit(0)
    check("no effect" not in program.stderr_text(), program.stderr_text())
    wanted = {shown(line, "arm")["sequence"]: line for line in lines_of(os.path.join(out, "frames.jsonl"))}
    check(len(wanted) == 2, f"{wanted}")

    replayed = test.renderer("--replay", recording(test), "--step", "--lockstep", "--exit-when-done", "--overlay", overlay, *PLAIN_IMAGES, scene=scene)
    replayed.expect_exit(0)
    same = {shown(line, "arm")["sequence"]: line for line in replayed.frames() if shown(line, "arm")}
    for sequence, line in wanted.items():
        picture = read_png(os.path.join(out, line["file"]))
        middle = picture.pixel(round(picture.width / 2 + PLACE_AT_REST + slide), picture.height // 2 + 30)
        check(tuple(middle) == (255, 255, 0), f"no yellow where the joint puts it, but {middle}")
        colours = {picture.pixel(x, y) for x in range(picture.width) for y in range(picture.height)}
        check((0, 255, 0) in colours and (255, 0, 0) not in colours, f"the red square is not that of the variant: {colours}")
        check(picture.rows == pixels_of(replayed.folder, same[sequence]), f"frame {sequence} is another picture in a replay")


def shards_are_the_whole(test):
    folder = whole_run(test)
    parts = [test.path(f"part{i}") for i in (1, 2, 3)]
    for i, part in enumerate(parts, 1):  # one of them on two devices
        render(test, recording(test), part, "--fps", FPS, "--shard", f"{i}/3", *(["--devices", "0,0"] if i == 2 else []))
    check(sum(len(files_of(part)) - 1 for part in parts) == FRAMES, "a frame is in no part or in two")
    joined = test.path("joined")
    said = join(test, parts[2], parts[0], parts[1], "--out", joined)
    check("warning" not in said, said)
    check(files_of(joined) == files_of(folder), "joined shards are other bytes than a single run")

    # One video of all shards equals a direct one.
    straight, together = test.path("straight.mp4"), test.path("together.mp4")
    render(test, recording(test), straight, "--fps", FPS)
    join(test, *parts, "--out", together)
    check(open(straight, "rb").read() == open(together, "rb").read(), "the joined video is another one")
    lists = [[{**line, "file": ""} for line in lines_of(path)]
             for path in (straight + ".jsonl", together + ".jsonl", os.path.join(folder, "frames.jsonl"))]
    check(lists[0] == lists[1] == lists[2], "the lists beside videos are other ones")

    outputs_are_written(test)

    # Shards that do not match, or are incomplete, are reported.
    said = join(test, parts[0], parts[2], "--out", test.path("x.mp4"), code=1)
    check("frames 13 to 25 of 40 are missing: render again with --shard 2/3" in said, said)
    check("name each part once" in join(test, *parts, parts[1], "--out", test.path("x.mp4"), code=1), "a part was taken twice")
    os.unlink(os.path.join(parts[1], "frame_000015.png"))
    said = join(test, *parts, "--out", test.path("x.mp4"), code=1)
    check("frame 15 of 40 is missing" in said, said)
    render(test, recording(test), parts[1], "--fps", FPS, "--shard", "2/3")
    manifest = os.path.join(parts[1], "manifest.json")
    text = open(manifest, encoding="utf-8").read()
    with open(manifest, "w", encoding="utf-8") as file:
        file.write(text.replace('"cpu": "', '"cpu": "another '))
    said = join(test, *parts, "--out", test.path("y.mp4"))
    check("warning" in said and "another" in said, said)
    with open(manifest, "w", encoding="utf-8") as file:
        file.write(text.replace("--tone-map none", "--tone-map aces"))
    said = join(test, *parts, "--out", test.path("x.mp4"), code=1)
    plain = " ".join(PLAIN_IMAGES)
    check(f"do not belong together: look is --tone-map aces {plain} there and --tone-map none {plain} here" in said, said)
    shutil.copy(os.path.join(parts[0], "frame_000003.png"), os.path.join(parts[1], "frame_000015.png"))
    with open(manifest, "w", encoding="utf-8") as file:
        file.write(text)
    said = join(test, *parts, "--out", test.path("x.mp4"), code=1)
    check("frame_000015.png is not the frame that its name says" in said, said)
    check(not any(name.startswith("x.mp4") for name in os.listdir(test.folder)), "something is left of a video that failed")


def outputs_are_written(test):
    """All outputs of each frame; motion is that since the frame before, also at the beginning of a shard."""
    outputs = "color,linear,depth,instance,semantic,normal,motion,occlusion,albedo,roughness,metallic,position,boxes2d,boxes3d,amodal"
    arguments = ("--fps", FPS, "--start", 13 / FPS, "--end", 19 / FPS, "--outputs", outputs)  # between two changes of the scene
    folder, parts, joined = test.path("outputs"), [test.path(f"outputs{i}") for i in (1, 2)], test.path("outputs joined")
    render(test, recording(test), folder, *arguments)
    lines = lines_of(os.path.join(folder, "frames.jsonl"))
    for line in lines:
        check(set(line["planes"]) == set(outputs.split(",")) - {"color", "boxes2d", "boxes3d"}, f"{line}")
        check(line["boxes2d"] and line["boxes3d"] and line["amodal"] and len(line["bytes"]) == 13, f"{line}")
        check(pixels_of(folder, line) == read_png(os.path.join(whole_run(test), f"frame_{line['frame'] + 13:06}.png")).rows, "other colours")
    motions = [open(os.path.join(folder, line["planes"]["motion"]), "rb").read()[128:] for line in lines]
    check(not any(motions[0]) and all(any(motion) for motion in motions[1:]), "motion")
    for i, part in enumerate(parts, 1):
        render(test, recording(test), part, *arguments, "--shard", f"{i}/2")
    join(test, *parts, "--out", joined)
    check(files_of(joined) == files_of(folder), "joined shards of outputs are other bytes than a single run")
    for name in ("frame_000003.motion.npy", "frame_000005.png"):
        os.unlink(os.path.join(folder, name))
    said = render(test, recording(test), folder, *arguments)
    check("5 images are there already" in said and files_of(joined) == files_of(folder), "what was gone on with is other bytes")
    said = render(test, recording(test), folder, *arguments[:-1], "color,depth", code=1)
    check("outputs is " in said, said)
    said = render(test, recording(test), test.path("x"), *arguments, "--devices", "0,0", code=1)
    check("flow and motion compare images of one device" in said, said)
    arrays = test.path("depth alone")
    render(test, recording(test), arrays, *arguments[:-1], "depth")
    check("have no colours for a video" in join(test, arrays, "--out", test.path("x.mp4"), code=1), "a video without colours")


def a_killed_run_is_gone_on_with(test):
    folder = whole_run(test)
    out = test.path("killed")
    program = start(test, recording(test), out, "--fps", FPS)
    path = os.path.join(out, "frames.jsonl")
    wait_until(lambda: f"frames; it said:\n{program.stderr_text()}",
               lambda: os.path.exists(path) and len(open(path, "rb").read().splitlines()) >= 5 or not program.alive())
    program.kill()
    kept = len(lines_of(path))
    check(5 <= kept, "it did not come far enough")
    if kept == FRAMES:  # the kill came after the last frame on this machine: removes frames by hand
        for frame in range(20, FRAMES):
            os.unlink(os.path.join(out, f"frame_{frame:06}.png"))
        kept = 20
    before = {name: os.stat(os.path.join(out, name)).st_mtime_ns for name in files_of(out) if name.endswith(".png")}
    with open(path, "a", encoding="utf-8") as file:
        file.write('{"file":"frame_000030.png","frame":30,"cam')
    said = render(test, recording(test), out, "--fps", FPS)
    check(f"{kept} frames are there already" in said, said)
    check(files_of(out) == files_of(folder), "what was gone on with is other bytes than a single run")
    check(all(os.stat(os.path.join(out, f"frame_{frame:06}.png")).st_mtime_ns == before[f"frame_{frame:06}.png"]
              for frame in range(kept)), "frames that were there were drawn again")
    said = render(test, recording(test), out, "--fps", FPS)
    check("all frames are there already" in said, said)
    said = render(test, recording(test), out, "--fps", 25, code=1)
    check("holds frames of another run (fps is 50 there and 25 here)" in said, said)

    # A video is assembled from frame files, which are removed once it is complete.
    video = test.path("resumed.mkv")
    frames = video + ".frames"
    program = start(test, recording(test), video, "--fps", FPS, "--codec", "ffv1", "--resume")
    wait_until(lambda: f"frames; it said:\n{program.stderr_text()}",
               lambda: os.path.exists(os.path.join(frames, "frame_000004.png")) or not program.alive())
    program.signal(signal.SIGTERM)
    check(program.wait() in (0, 1), program.stderr_text())
    render(test, recording(test), video, "--fps", FPS, "--codec", "ffv1", "--resume")
    check(not os.path.exists(frames) and os.path.getsize(video) > 0, f"left: {os.listdir(test.folder)}")
    check([line["frame"] for line in lines_of(video + ".jsonl")] == list(range(FRAMES)), "frames are missing in the list")


def live_is_replayed_is_offline(test):
    frames = 24
    uri, file = test.fresh_uri("shm"), test.path("live.mcap")
    publisher = test.publisher(uri, nodes=("red", "blue"))
    live = test.renderer("--lockstep", "--exit-when-done", listen=[uri])
    live.uris()
    recorder = Program(test, "recorder", [test.programs_at["record"], "--from", uri, "--out", file, "--until-end"])
    recorder.wait_err(r"listening on")
    publisher.wait_welcome()
    publisher.do(f"lockstep {frames}")
    publisher.quit()
    live.expect_exit(0)
    recorder.expect_exit(0)

    offline = test.path("offline")
    render(test, file, offline, "--fps", 100, look=())  # the simulator's rate
    drawn = {shown(line, "arm")["sequence"]: line for line in lines_of(os.path.join(offline, "frames.jsonl"))}
    check(len(drawn) >= frames // 2, f"{len(drawn)} frames were recorded")

    again = test.fresh_uri("shm")
    replayed = test.renderer("--lockstep", "--exit-when-done", listen=[again])
    replayed.uris()
    # Steps frame by frame: a renderer that starts slowly would miss frames that the link does not hold.
    replay = Program(test, "replay", [test.programs_at["replay"], file, "--to", again, "--wait", "--step"])
    for sequence in sorted(drawn):
        replay.process.stdin.write("\n")
        replay.process.stdin.flush()
        replayed.wait_frame(f"frame {sequence}", lambda f: shown(f, "arm") and shown(f, "arm")["sequence"] >= sequence)
    replay.process.stdin.close()
    replay.expect_exit(0)
    replayed.expect_exit(0)
    for name, renderer in (("live", live), ("replayed", replayed)):
        compared = 0
        for line in renderer.frames():
            arm = shown(line, "arm")
            if not arm or arm["sequence"] not in drawn:
                continue
            compared += 1
            wanted = drawn[arm["sequence"]]
            check(shown(wanted, "arm")["sim_time_ns"] == arm["sim_time_ns"], f"{wanted} is not {line}")
            check(pixels_of(offline, wanted) == pixels_of(renderer.folder, line), f"{name}: frame {arm['sequence']} is another picture offline")
        check(compared >= frames // 2, f"{name}: only {compared} frames could be compared")


def the_scene_may_travel(test):
    folder = whole_run(test)
    out = test.path("travelled")
    render(test, recording(test, attach=True), out, "--fps", FPS, scene=False, *[])
    # The bytes differ by the digest of the recording, which the images carry.
    ours, theirs = lines_of(os.path.join(out, "frames.jsonl")), lines_of(os.path.join(folder, "frames.jsonl"))
    check(ours == theirs and all(pixels_of(out, line) == pixels_of(folder, line) for line in ours),
          "the scene in the recording looks other than the same one beside it")


def bad_input(test):
    file, out = recording(test), test.path("nowhere")
    cut, empty = test.path("cut.mcap"), test.path("empty.mcap")
    with open(file, "rb") as whole, open(cut, "wb") as part:
        content = whole.read()
        part.write(content[:len(content) // 2])
    open(empty, "w").close()
    with open(test.path("bag.db3"), "wb") as other:
        other.write(b"SQLite format 3\0")
    for arguments, code, sentence in (
            ([], 2, "name the recording first"),
            ([file], 2, "--out: name a video"),
            ([file, test.scene, "--out", out, "--fps", "0"], 2, "--fps 0"),
            ([file, test.scene, "--out", out, "--shard", "3/2"], 2, "--shard 3/2"),
            ([file, test.scene, "--out", out, "--crf", "3"], 2, "is a folder"),
            ([file, test.scene, "--out", "x.avi"], 2, ".mp4, .mkv or .webm"),
            ([file, test.scene, "--out", "x.mp4", "--shard", "1/2"], 2, "name a folder"),
            ([file, test.scene, "--out", out, "--listen", "shm://x"], 2, "--listen"),
            ([file, test.scene, "--out", out, "--outputs", "depht"], 2, "--outputs"),
            ([file, test.scene, "--out", "x.mp4", "--outputs", "depth"], 2, "name a folder with --out"),
            ([test.scene, file, "--out", out], 2, f"the recording comes first, then the scene: fire3dv render {file} {test.scene}"),
            ([test.scene, "--out", out], 2, "is a scene, and no recording: fire3dv dataset draws scenes"),
            ([test.path("bag.db3"), test.scene, "--out", out], 2, "holds states of another program, which fire3dv relabel draws"),
            ([file, test.scene, "--out", out, "--play=latest"], 2, "--play is for streams that are live"),
            ([file, test.scene, "--out", out, "--start", "nan"], 2, "--start"),
            ([file, test.scene, "--out", out, "--start", "5"], 1, "is 0.790 s of simulated time long"),
            ([file, test.scene, "--out", out, "--clock", "lathe"], 1, 'it has "arm", "crane"'),
            ([file, "--out", out], 1, "has no scene in it"),
            ([file, "/nowhere.glb", "--out", out], 1, "/nowhere.glb"),
            ([recording(test, attach=True), "--out", out, "--camera", "nope"], 1, "--camera nope: asset.glb in "),
            ([empty, test.scene, "--out", out], 1, "is not an MCAP file"),
            ([test.path("none.mcap"), test.scene, "--out", out], 1, "cannot be opened"),
            ([file, test.scene, "--out", test.path("v.webm"), "--codec", "h264"], 1, "these are: av1"),
            ([file, test.scene, "--out", test.path("v.mp4"), "--size", "65x64"], 1, "65x64"),
            ([file, test.scene, "--out", test.scene + "/x"], 1, "squares.glb/x")):
        program = Program(test, "render", [test.programs_at["fire3dv"], "render", *arguments, *(["--cache", "off"] if arguments else [])],
                          vulkan_environment())
        check(program.wait() == code, f"{arguments} ended with {program.process.returncode}:\n{program.stderr_text()}")
        check(sentence in program.stderr_text(), f"{arguments} said:\n{program.stderr_text()}")
        check(not os.path.exists(out), f"{arguments} left a folder")
    check("has no manifest.json" in join(test, test.folder, "--out", out, code=1), "a folder without frames was taken")

    # A truncated recording is drawn up to its end. A full disk is an error, and all written frames are whole.
    said = render(test, cut, out, "--fps", FPS)
    check("warning" in said and 5 <= len(lines_of(os.path.join(out, "frames.jsonl"))) < FRAMES, said)

    disk = test.path("disk")
    os.mkdir(disk)
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=24k", "fire3dv-test", disk], capture_output=True).returncode != 0:
        print("left out: a disk that is full, which takes root to make", flush=True)
        return
    try:
        for name in ("full", "full.mkv"):
            path = os.path.join(disk, name)
            said = render(test, file, path, "--fps", FPS, *(["--codec", "ffv1"] if name.endswith("mkv") else []), code=1)
            check("No space left on device; free some" in said, f"{name}: {said}")
            if name == "full":
                kept = lines_of(os.path.join(path, "frames.jsonl"))
                check(all(read_png(os.path.join(path, line["file"])) for line in kept), "half a frame is listed")
                shutil.rmtree(path)
        check(not os.listdir(disk), f"left of a video that failed: {os.listdir(disk)}")
    finally:
        subprocess.run(["umount", disk], check=True)


if __name__ == "__main__":
    def all_of(*parts):
        def run(test):
            for part in parts:
                part(test)
        return run
    # One folder for all comparisons with the reference run, which is drawn once.
    main({"same_bytes": all_of(frames_are_right, a_cold_start_changes_nothing, shards_are_the_whole, a_killed_run_is_gone_on_with,
                               the_scene_may_travel),
          "paths": all_of(paths_are_traced, a_killed_path_is_gone_on_with), "overlay": all_of(an_overlay_is_applied, joints_are_moved), "live": live_is_replayed_is_offline, "bad_input": bad_input},
         ("fire3dv", "record", "replay", "publisher", "make"))
