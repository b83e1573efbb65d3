"""Declarations of the C headers, one normalised line each: functions, members of structs, constants, opaque types."""
import glob
import os
import re


def _without_comments(text):
    text = re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.DOTALL)
    return re.sub(r"\\\n", " ", text)


def _line(text):
    text = re.sub(r"\s+", " ", text).strip()
    text = re.sub(r"\s*(\*[\s*]*)", lambda stars: re.sub(r"\s", "", stars[1]) + " ", text)  # "char *a", "char* a"
    return re.sub(r"\s*([(),\[\]])\s*", r"\1", text).replace(",", ", ")


def _members(name, body):
    """Members in their order: programs depend on offsets. A new one at the end changes no other line."""
    for index, member in enumerate(filter(None, map(_line, body.split(";")))):
        yield f"struct {name}[{index}] {member}"


def _constants(body):
    number = -1
    for constant in filter(None, map(_line, body.split(","))):
        name, _, value = map(str.strip, constant.partition("="))
        number = int(value, 0) if re.fullmatch(r"-?(0x)?[0-9a-fA-F]+", value) else value or number + 1
        yield f"enum {name} = {number}"


def declarations(path):
    with open(path, encoding="utf-8") as file:
        text = _without_comments(file.read())
    for name, value in re.findall(r"(?m)^#define (FIRE3DV_\w+) (\S.*)$", text):
        if name != "FIRE3DV_API":
            yield f"define {name} {_line(value)}"
    text = re.sub(r"(?m)^\s*#.*$|extern \"C\" \{", "", text)
    pattern = re.compile(r"typedef struct (?P<struct>\w+) \{(?P<members>.*?)\} \w+;|enum(?: \w+)? \{(?P<constants>.*?)\};|"
                         r"typedef (?P<type>[^;{]+);|FIRE3DV_API (?P<function>[^;{]+);|static inline (?P<inline>[^;{]+)\{.*?\n\}", re.DOTALL)
    rest = pattern.sub("", text).replace("}", "").strip()
    if rest:
        raise ValueError(f"{path}: not understood: {rest[:200]}")
    for found in pattern.finditer(text):
        if found["struct"]:
            yield from _members(found["struct"], found["members"])
        elif found["constants"]:
            yield from _constants(found["constants"])
        elif found["type"]:
            yield f"typedef {_line(found['type'])}"
        elif found["inline"]:
            yield f"inline {_line(found['inline'])}"
        else:
            yield f"function {_line(found['function'])}"


def public_interface(root):
    for path in sorted(glob.glob(os.path.join(root, "adapters", "generic", "include", "fire3dv", "*.h"))):
        yield from declarations(path)


def name_of(line):
    kind, rest = line.split(" ", 1)
    return re.search(r"(\w+)\(", rest).group(1) if kind in ("function", "inline") else re.findall(r"FIRE3DV_\w+|fire3dv_\w+", rest)[0]
