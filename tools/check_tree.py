#!/usr/bin/env python3
"""Structure of the tree: include directions, circles of folders, opening comments, sizes of folders and classes, Markdown lines, headers that
stand alone.

    check_tree.py                  all checks; exit 1 and one line for each violation
    check_tree.py --lone-headers   the headers that no source file of the same name includes first

ARCHITECTURE.md shows the order of folders; ALLOWED is the exact rule. A header is compiled alone when a source file includes it first, before
everything else; tests/unit/headers.cmake compiles those of --lone-headers.
"""
import json
import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SOURCES = (".h", ".hpp", ".c", ".cpp", ".glsl", ".comp", ".vert", ".frag", ".rgen", ".rahit", ".rmiss", ".py", ".mjs")
MAX_FILES_IN_FOLDER = 25
MAX_MARKDOWN_COLUMNS = 100
MAX_CLASS_MEMBERS = 60
REASON_OF_CLASS = f"More than {MAX_CLASS_MEMBERS} members: "
QUESTION = re.compile(r"^(What|Which|Who|Whose|Where|How|From|Does|Do|Whether|Why|When)\b")

# Folder: the folders that its files may include, beside its own. The longest matching prefix counts. "a/*" are the files of a
# alone, without its sub-folders.
BASE = "base"
WIRE = BASE + " protocol/wire"
MODEL = BASE + " renderer/scene convert/*"
# Rooms of the renderer below its program.
ROOMS = ("renderer/streams renderer/live_scene renderer/loading renderer/editing renderer/camera renderer/images renderer/browser/* "
         "renderer/window")
ALLOWED = {
    "base": "",
    "protocol/wire": BASE,
    "protocol/stream": WIRE,
    "protocol/transport": WIRE,
    "protocol/frames": BASE,
    "protocol/robot": WIRE,
    "protocol/record": WIRE + " protocol/stream",
    "protocol/import": WIRE + " protocol/frames protocol/robot protocol/record",
    "protocol/replay": WIRE + " protocol/stream protocol/record protocol/transport",
    "adapters/generic": WIRE + " protocol/robot protocol/transport",
    "adapters/ambf": WIRE + " adapters/generic",
    # The model's scene by the converter, and images as files.
    "adapters/mujoco": WIRE + " adapters/generic renderer/scene renderer/sinks convert",
    # The world's scene as glTF.
    "adapters/gazebo": WIRE + " adapters/generic renderer/scene convert",
    "adapters/ros2": WIRE + " protocol/frames adapters/generic",
    "examples": "adapters/generic examples/common",
    "examples/common": "examples adapters/generic base/glb.h base/command_line.h",
    "shaders": "",
    "renderer/scene": WIRE,
    "renderer/gpu": BASE + " shaders",
    "renderer/state": WIRE + " protocol/robot protocol/stream renderer/scene",
    "renderer/settings": BASE + " renderer/scene",
    "renderer/passes": WIRE + " shaders renderer/gpu renderer/scene renderer/settings renderer/state",
    "renderer/sinks": WIRE + " renderer/gpu renderer/state",
    "renderer/capture": WIRE + " renderer/gpu renderer/scene renderer/state renderer/settings renderer/passes renderer/sinks",
    "renderer/metrics": WIRE + " protocol/transport",
    "renderer/gui": BASE + " protocol/robot protocol/replay shaders renderer/gpu renderer/scene renderer/state renderer/editing "
                           "renderer/settings renderer/passes",
    "renderer/offline": WIRE + " protocol/record renderer/scene renderer/gpu renderer/state renderer/settings renderer/passes renderer/sinks "
                               "renderer/capture renderer/app " + ROOMS,
    "renderer/dataset": WIRE + " protocol/record protocol/robot renderer/scene renderer/state renderer/settings renderer/passes/view renderer/passes/outputs renderer/sinks renderer/camera renderer/app "
                               "renderer/offline",
    "renderer/relabel": WIRE + " protocol/robot protocol/record protocol/import renderer/scene renderer/state renderer/app renderer/offline renderer/dataset "
                               "renderer/loading",
    "renderer/verify": WIRE + " renderer/scene renderer/state renderer/camera renderer/sinks renderer/app renderer/offline renderer/dataset",
    "renderer/doctor": BASE + " protocol/transport renderer/gpu renderer/scene renderer/state renderer/settings renderer/passes renderer/loading",
    "convert": BASE + " renderer/scene",
    "convert/glb": MODEL,
    "convert/mesh/text": MODEL + " convert/mesh/geometry",
    "convert/mesh/geometry": MODEL,
    "convert/mesh": MODEL + " convert/glb convert/mesh/text convert/mesh/geometry",
    "convert/adf": MODEL + " convert/mesh",
    "convert/mjcf/xml": MODEL,
    "convert/mjcf/scene": MODEL + " convert/mesh",
    "convert/mjcf/assets": MODEL + " convert/glb convert/mesh convert/mesh/geometry convert/mjcf/scene convert/mjcf/xml",
    "convert/mjcf/bodies": MODEL + " convert/mjcf/assets convert/mjcf/scene convert/mjcf/xml",
    "convert/mjcf/deformable": MODEL + " convert/mjcf/bodies convert/mjcf/assets convert/mjcf/scene convert/mjcf/xml",
    "convert/mjcf": MODEL + " convert/mjcf/deformable convert/mjcf/bodies convert/mjcf/assets convert/mjcf/scene convert/mjcf/xml",
    "convert/sdf/files": MODEL,
    "convert/sdf": MODEL + " convert/glb convert/mesh convert/sdf/files",
    "convert/sdf/library": MODEL + " convert/sdf/files convert/sdf/*",
    "convert/xacro/expression": MODEL,
    "convert/xacro": MODEL + " convert/xacro/expression",
    "convert/urdf": MODEL + " convert/mesh convert/xacro",
    # A program that renders by itself, as renderer/offline does.
    "programs/drake": WIRE + " protocol/transport renderer/scene renderer/gpu renderer/state renderer/settings renderer/passes renderer/sinks "
                             "renderer/capture renderer/app " + ROOMS,
}
MODULES = (WIRE + " protocol/robot protocol/transport renderer/scene renderer/gpu renderer/state renderer/settings renderer/passes renderer/sinks "
                  "renderer/capture renderer/gui ")
ALLOWED |= {
    "renderer/camera": BASE + " renderer/scene renderer/state renderer/settings renderer/passes/view renderer/passes/outputs/planes_and_boxes.h",
    "renderer/streams": WIRE + " protocol/transport renderer/scene renderer/state",
    "renderer/live_scene": WIRE + " shaders renderer/scene renderer/state",
    "renderer/loading": BASE + " renderer/scene renderer/gpu renderer/settings renderer/passes renderer/live_scene",
    "renderer/images": MODULES + "renderer/streams renderer/live_scene renderer/loading",
    "renderer/editing": BASE + " protocol/robot renderer/scene renderer/state renderer/settings renderer/live_scene",
    "renderer/browser/server": WIRE + " protocol/transport renderer/sinks",
    "renderer/browser": MODULES + "protocol/replay renderer/browser/server renderer/camera renderer/streams renderer/live_scene "
                                  "renderer/images renderer/editing",
    "renderer/window": MODULES + "protocol/replay renderer/metrics renderer/camera renderer/streams renderer/live_scene "
                                 "renderer/images renderer/editing",
    "renderer/app/options": MODULES + ROOMS,
    "renderer/app": MODULES + "shaders protocol/record protocol/replay protocol/stream renderer/metrics renderer/browser/server "
                              "renderer/app/options " + ROOMS,
    "renderer/app/run": MODULES + "protocol/record protocol/replay renderer/browser/server renderer/app/* renderer/app/loop "
                                  "renderer/app/options " + ROOMS,
}


def git_files():
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z"], capture_output=True, text=True, check=True)
    return [name for name in listed.stdout.split("\0") if name and os.path.isfile(os.path.join(ROOT, name))]


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8", errors="replace") as file:
        return file.read()


def includes(text):
    return re.findall(r'^\s*#\s*include\s*"([^"]+)"', text, re.M)


def within(name, folder):
    return name == folder or name.startswith(folder + "/")


def room_of(name):
    return max((folder for folder in ALLOWED if within(name, folder)), key=len, default=None)


def matches(name, folder):
    return os.path.dirname(name) == folder[:-2] if folder.endswith("/*") else within(name, folder)


def include_directions(name, text):
    room = room_of(name)
    if room is None:
        return
    for target in includes(text):
        if not re.match(r"(base|protocol|renderer|convert|programs|adapters|tools|examples|tests|shaders)/", target):
            continue
        if room_of(target) != room and not any(matches(target, folder) for folder in ALLOWED[room].split()):
            yield f"{name} includes {target}: {room}/ may not depend on it (ALLOWED in tools/check_tree.py)"


def circles(texts):
    """Folders that include one another (Tarjan's strongly connected components). texts: of files, by name."""
    edges, example = {}, {}
    for name, text in texts.items():
        folder = os.path.dirname(name)
        for target in includes(text):
            other = os.path.dirname(target)
            if target in texts and other != folder:
                edges.setdefault(folder, set()).add(other)
                example.setdefault((folder, other), f"{name} includes {target}")
    number, lowest, stack, found = {}, {}, [], []

    def visit(folder):
        number[folder] = lowest[folder] = len(number)
        stack.append(folder)
        for other in sorted(edges.get(folder, ())):
            if other not in number:
                visit(other)
            if other in stack:
                lowest[folder] = min(lowest[folder], lowest[other])
        if lowest[folder] == number[folder]:
            at = stack.index(folder)
            found.append(stack[at:])
            del stack[at:]

    for folder in sorted(edges):
        if folder not in number:
            visit(folder)
    for circle in found:
        if len(circle) > 1:
            steps = [text for (a, b), text in sorted(example.items()) if a in circle and b in circle]
            yield f"{', '.join(sorted(circle))} include one another: {'; '.join(steps)}"


def opening_comment(name, text):
    lines = text.split("\n")
    if lines and lines[0].startswith("#!"):
        lines = lines[1:]
    first = next((line for line in lines if line.strip()), "")
    sentence = re.match(r'\s*(?://+|#|"""|/\*+)\s*(.*)', first)
    if sentence and QUESTION.match(sentence.group(1)):
        yield f"{name}: the opening comment begins with a question word; name the thing instead"


def markdown_lines(name, text):
    in_code = False
    for number, line in enumerate(text.split("\n"), 1):
        if line.lstrip().startswith("```"):
            in_code = not in_code
        wrappable = not in_code and not line.lstrip().startswith("|") and " " in line.strip()[:MAX_MARKDOWN_COLUMNS]
        if wrappable and len(line) > MAX_MARKDOWN_COLUMNS:
            yield f"{name}:{number}: {len(line)} columns; lines of Markdown end at {MAX_MARKDOWN_COLUMNS}"


def folder_sizes(files):
    counts = {}
    for name in files:
        if name.endswith(SOURCES):
            counts[os.path.dirname(name)] = counts.get(os.path.dirname(name), 0) + 1
    for folder, count in sorted(counts.items()):
        if count > MAX_FILES_IN_FOLDER:
            yield f"{folder}: {count} source files in one folder; {MAX_FILES_IN_FOLDER} at most: give them sub-folders"


# Data members and methods of classes, as universal-ctags counts them. Overloads count once.
def class_sizes(files):
    if not shutil.which("ctags"):
        print("check_tree.py: classes not counted: universal-ctags is not installed")
        return
    headers = [name for name in files if name.endswith((".h", ".hpp")) and not name.startswith("tests/")]
    tags = subprocess.run(["ctags", "-f", "-", "--languages=C++", "--map-C++=+.h", "--kinds-C++=mpf", "--fields=+Ks",
                           "--output-format=json", *headers], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    members = {}
    for tag in map(json.loads, tags.splitlines()):
        if tag.get("scopeKind") in ("class", "struct"):
            members.setdefault((tag["path"], tag["scope"]), set()).add(tag["name"])
    for (name, scope), names in sorted(members.items()):
        if len(names) > MAX_CLASS_MEMBERS and REASON_OF_CLASS not in read(name):
            yield (f"{name}: {scope} has {len(names)} members and methods; {MAX_CLASS_MEMBERS} at most, or a sentence "
                   f"\"{REASON_OF_CLASS}...\" in its header")


def lone_headers(files):
    first_included = set()
    for name in files:
        if name.endswith(".cpp"):
            first_included.update(includes(read(name))[:1])
    return [name for name in files if name.endswith(".h") and name not in first_included
            and name.startswith(("base/", "protocol/", "renderer/", "convert/", "programs/", "tools/"))]


def main():
    files = git_files()
    if sys.argv[1:] == ["--lone-headers"]:
        print("\n".join(lone_headers(files)))
        return 0
    if sys.argv[1:]:
        print(__doc__, file=sys.stderr)
        return 2
    faults = [*folder_sizes(files), *class_sizes(files)]
    faults += circles({name: read(name) for name in files
                       if name.endswith((".h", ".hpp", ".c", ".cpp")) and not name.startswith(("tests/", "tools/"))})
    for name in files:
        text = read(name) if name.endswith((*SOURCES, ".md", ".sh", ".cmake", "CMakeLists.txt")) else ""
        if name.endswith((".h", ".hpp", ".c", ".cpp")):
            faults += include_directions(name, text)
        if name.endswith((*SOURCES, ".sh", ".cmake", "CMakeLists.txt")):
            faults += opening_comment(name, text)
        if name.endswith(".md"):
            faults += markdown_lines(name, text)
    for fault in faults:
        print(fault)
    print(f"check_tree.py: {len(files)} files, {len(faults)} violations")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
