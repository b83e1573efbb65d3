"""Python reference as Markdown, from the docstrings and annotations of the package; it is imported, not run.

Fails for a public name without a docstring, and for a function with an argument or result without annotation.
"""
import enum
import importlib
import inspect
import os
import re
import sys

from .c_reference import ReferenceFault
from .pages import ROOT

PACKAGE = os.path.join(ROOT, "adapters/generic/python")
# Page: title, names of fire3dv or of one of its modules.
PAGES = {
    "stream": ("Stream", "fire3dv", ("Stream", "Status", "Welcome", "FRAME_DISCONTINUITY", "Property", "LightKind", "MarkerKind")),
    "controls": ("Controls", "fire3dv", ("Controls", "Control", "Event", "InputKind", "Action")),
    "renderer": ("Renderer", "fire3dv", ("Renderer", "find_program", "show", "LiveView")),
    "images": ("Images", "fire3dv", (
        "Image", "ImageRequest", "CalibratedCamera", "read_calibration", "OUTPUTS", "ALIASES", "Output", "When", "Lens")),
    "batch": ("Batches", "fire3dv", ("Batch", "BatchRequest")),
    "robot": ("Robot", "fire3dv", ("Robot", "RobotPublisher", "Joint", "JointType")),
    "poses": ("Poses", "fire3dv", ("pose", "look_at")),
    "errors": ("Errors and versions", "fire3dv", (
        "Error", "ErrorCode", "ArgumentError", "BudgetError", "LibraryNotFound", "OperatingSystemError", "RefusedError", "RendererError",
        "RendererNotFound", "SceneWarning", "StateError", "Timeout", "version", "__version__")),
    "mujoco": ("fire3dv.mujoco", "fire3dv.mujoco", None),
    "pybullet": ("fire3dv.pybullet", "fire3dv.pybullet", None),
    "sofa": ("fire3dv.sofa", "fire3dv.sofa", None),
}
MADE_BY_LIBRARY = ("Image", "ImageRequest", "Batch", "BatchRequest", "RobotPublisher", "Controls", "Control", "Event")  # never by users: no signature of the class


def escaped(text):
    return re.sub(r"([*<>\[\]])", r"\\\1", text)


def fields_listed(lines):
    """List items of lines such as "width, height: pixels"; lines that begin with spaces continue the one above."""
    items = []
    for line in lines:
        if line.startswith(" ") and items:
            items[-1] += " " + line.strip()
        else:
            names, colon, text = line.partition(": ")
            items.append(f"- `{names}`: {escaped(text)}" if colon else f"- {escaped(line)}")
    return items


def arguments_listed(text, arguments):
    """A paragraph such as "uri: ... adapter_name: ..." as a list, other text as it is."""
    names = rf"(?:{'|'.join(map(re.escape, arguments))}|\w+_\*)"
    start = rf"{names}(?:, {names})*: "
    if not arguments or not re.match(start, text):
        return escaped(text)
    parts = re.split(rf"(?<=[.;)]) (?={start})", text)
    return "\n".join(fields_listed(parts))


def prose_of(docstring, arguments=()):
    """Markdown of a docstring: indented blocks are code, indented lines below text are fields. arguments: of a function."""
    parts = []
    for block in re.split(r"\n\s*\n", inspect.cleandoc(docstring)):
        lines = block.split("\n")
        if all(line.startswith("    ") for line in lines):
            parts.append("```python\n" + "\n".join(line[4:] for line in lines) + "\n```")
            continue
        head = [line for line in lines if not line.startswith("    ")]
        rest = [line[4:] for line in lines if line.startswith("    ")]
        parts.append(arguments_listed(" ".join(head), arguments))
        if rest:
            parts.append("\n".join(fields_listed(rest)))
    return "\n\n".join(parts)


def arguments_of(function):
    return [name for name in inspect.signature(function).parameters if name != "self"]


def docstring_of(value, name):
    own = value.__dict__.get("__doc__") if inspect.isclass(value) else inspect.getdoc(value)
    if not own or own == "An enumeration.":
        raise ReferenceFault(f"{name} has no docstring")
    return prose_of(own, arguments_of(value) if inspect.isfunction(value) else ())


def text_of(annotation):
    return annotation.strip("\"'") if isinstance(annotation, str) else getattr(annotation, "__name__", str(annotation))


def signature_of(function, name, shown):
    signature = inspect.signature(function)
    for argument in signature.parameters.values():
        if argument.name != "self" and argument.annotation is inspect.Parameter.empty:
            raise ReferenceFault(f"{name}: the argument {argument.name} has no annotation")
    if signature.return_annotation is inspect.Signature.empty:
        raise ReferenceFault(f"{name}: its result has no annotation")
    arguments = []
    for each in signature.parameters.values():
        if each.kind is inspect.Parameter.KEYWORD_ONLY and "*" not in arguments:
            arguments.append("*")
        if each.name != "self":
            stars = "**" if each.kind is inspect.Parameter.VAR_KEYWORD else ""
            default = "" if each.default is inspect.Parameter.empty else f" = {each.default!r}"
            arguments.append(f"{stars}{each.name}: {text_of(each.annotation)}{default}")
    result = text_of(signature.return_annotation)
    line = f"{shown}({', '.join(arguments)})" + ("" if shown[0].isupper() and "." not in shown else f" -> {result}")
    if len(line) > 100:
        line = f"{shown}(\n    " + ",\n    ".join(arguments) + line[line.rindex(")"):]
    return f"```python\n{line}\n```"


def fields_of(value):
    """Rows of a table of an enumeration's members or a data class's fields, with their #: comments."""
    source = inspect.getsource(value)
    rows = []
    for line in source.split("\n"):
        match = re.match(r"    (\w+)(?:: ([^=#]+?))?(?: *= *(.+?))?(?:  #: (.*))?$", line)
        if match and not match.group(1).startswith("_") and (match.group(2) or match.group(3)):
            name, kind, number, comment = match.groups()
            rows.append(f"| `{name}` | {f'`{kind}`' if kind else number} | {escaped(comment or '')} |")
    return "| name | type or value | |\n|---|---|---|\n" + "\n".join(rows) if rows else ""


def of_class(name, value):
    parts = [f"## {name}"]
    is_enumeration = issubclass(value, enum.Enum)
    has_fields = is_enumeration or hasattr(value, "__dataclass_fields__")
    is_made = "__init__" in value.__dict__ and not has_fields and not issubclass(value, Exception) and name not in MADE_BY_LIBRARY
    if is_made:
        parts.append(signature_of(value.__init__, name, name))
    parts.append(docstring_of(value, name))
    if issubclass(value, Exception):
        parts.append("Bases: " + ", ".join(f"`{base.__name__}`" for base in value.__bases__) + ".")
    if is_made and value.__init__.__doc__:
        parts.append(prose_of(value.__init__.__doc__, arguments_of(value.__init__)))
    if has_fields:
        parts.append(fields_of(value))
    for member_name, _ in inspect.getmembers(value):
        owner = next((base for base in value.__mro__ if member_name in base.__dict__), None)
        if member_name.startswith("_") or owner is None or not owner.__module__.startswith("fire3dv"):
            continue
        member = owner.__dict__[member_name]
        full = f"{name}.{member_name}"
        if isinstance(member, property):
            kind = member.fget.__annotations__.get("return")
            if kind is None:
                raise ReferenceFault(f"{full}: its result has no annotation")
            parts += [f"### {full}", f"```python\n{full}: {text_of(kind)}\n```", docstring_of(member.fget, full)]
        elif inspect.isfunction(member) or isinstance(member, (classmethod, staticmethod)):
            function = getattr(member, "__func__", member)
            parts += [f"### {full}", signature_of(function, full, full), docstring_of(function, full)]
    return parts


def of_value(name, module):
    """A constant or a type of literals: its value, and the #: comment above or beside it."""
    value = getattr(module, name)
    comments = []
    for each in [module, *[sys.modules[key] for key in sorted(sys.modules) if key.startswith("fire3dv.")]]:
        source = inspect.getsource(each)
        match = re.search(rf"((?:^#: .*\n)*)^{name}(?::[^=\n]*)? = .*?(?:#: (.*))?$", source, re.M)
        if match:
            comments = [line[3:] for line in match.group(1).splitlines()] or ([match.group(2)] if match.group(2) else [])
            break
    if not comments:
        raise ReferenceFault(f"{name} has no comment that begins with #:")
    shown = "" if isinstance(value, dict) and len(str(value)) > 300 else f"```python\n{name} = {str(value).replace('typing.', '')}\n```"
    if isinstance(value, dict) and not shown:
        shown = "Keys: " + ", ".join(f"`{key}`" for key in value) + "."
    return [f"## {name}", " ".join(comments), shown]


def pages():
    """Markdown of all pages, by name below reference/python."""
    sys.path.insert(0, PACKAGE)
    sys.dont_write_bytecode = True
    package = importlib.import_module("fire3dv")
    listed = {name for _, module, names in PAGES.values() if module == "fire3dv" for name in names}
    members = {name for kind in (package.ErrorCode, package.Property, package.LightKind) for name in
               (*kind.__members__, *(f"ERROR_{each}" for each in kind.__members__))}  # members by their own names
    lost = set(package.__all__) - listed - members
    if lost:
        raise ReferenceFault(f"fire3dv.{sorted(lost)[0]} is on no page of PAGES in tools/site_tools/python_reference.py")
    result, rows = {}, []
    for file, (title, module_name, names) in PAGES.items():
        module = importlib.import_module(module_name)
        if names is None:
            names = [name for name, value in inspect.getmembers(module) if not name.startswith("_") and
                     getattr(value, "__module__", None) == module_name]
        parts = [f"# {title}"]
        if module is not package:
            parts.append(prose_of(module.__doc__))
        for name in names:
            value = getattr(module, name)
            if inspect.isclass(value):
                parts += of_class(name, value)
            elif inspect.isfunction(value):
                parts += [f"## {name}", signature_of(value, name, f"{module_name}.{name}"), docstring_of(value, name)]
            else:
                parts += of_value(name, module)
        result[f"{file}.md"] = "\n\n".join(part for part in parts if part) + "\n"
        rows.append(f"| [{title}]({file}.md) | {', '.join(f'`{name}`' for name in names)} |")
    result["index.md"] = "\n".join([
        "# Python reference", "",
        "Names of the package `fire3dv`. Their use: [Python](../../adapters/generic/python/README.md). The package is",
        "annotated (`py.typed`): type checkers and editors need no stubs.", "",
        "In signatures, `Array` is a NumPy array or a sequence of numbers, `Float32Array` and `Float64Array` are NumPy",
        "arrays of that type, `Path` is a string or a `pathlib.Path`.", "",
        "Members of `ErrorCode`, `Property` and `LightKind` are also names of the package: `fire3dv.ERROR_STATE`,",
        "`fire3dv.VISIBLE`, `fire3dv.SPOT`.", "",
        "| page | names |", "|---|---|", *rows, ""])
    return result
