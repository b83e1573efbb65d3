"""C reference as Markdown, one page for each public header of the client library, from its comments and declarations.

Fails for a public function, structure or enumeration without a comment, its own or that of the declaration right above it.
"""
import os
import re

from .pages import ROOT, read

FOLDER = "adapters/generic/include/fire3dv"
ORDER = ("client", "scene", "markers", "scalars", "input", "image", "batch", "joints")
ENUMERATOR = r"\b(FIRE3DV_[A-Z0-9_]+)(?= =|,)"
LABEL = re.compile(r"(?<=\. )((?:[A-Z][a-z-]+)(?:,? (?:and )?[a-z-]+){0,3}): ")


class ReferenceFault(Exception):
    """A public name that cannot be documented; the text names it."""


def comment_lines(comment):
    """Lines of a /* */ comment without its frame."""
    body = comment.strip()[2:-2]
    return [re.sub(r"^ *\* ?", "", line).rstrip() for line in body.split("\n")]


def escaped(text):
    text = re.sub(r"([*<>\[\]])", r"\\\1", text)
    return re.sub(r"(?<![\w/`])((?:fire3dv|FIRE3DV)_\w+)(\\\*)?", lambda match: f"`{match.group(1)}{'*' if match.group(2) else ''}`", text)


def prose_of(lines):
    """Markdown of comment lines: indented ones are code, labels such as "Thread-safety:" begin paragraphs."""
    blocks = []
    for line in lines:
        kind = "code" if line.startswith("  ") else "text"
        if not line:
            blocks.append(("end", []))
            continue
        if not blocks or blocks[-1][0] != kind:
            blocks.append((kind, []))
        blocks[-1][1].append(line[2:] if kind == "code" else line.strip())
    parts = []
    for kind, content in blocks:
        if kind == "code":
            parts.append("```c\n" + "\n".join(line[1:] if line.startswith(" ") else line for line in content) + "\n```")
        elif kind == "text":
            text = LABEL.sub(r"\n\n**\1:** ", escaped(" ".join(content)))
            text = re.sub(r"^([A-Z][a-z-]+(?:,? (?:and )?[a-z-]+){0,3}): ", r"**\1:** ", text)
            parts.append(text)
    return "\n\n".join(parts)


def declarations(text):
    """Yields (comment or None, code) of each declaration between the extern "C" of a header."""
    body = text.split('extern "C" {\n#endif\n', 1)[1].rsplit("#ifdef __cplusplus", 1)[0]
    position, comment = 0, None
    token = re.compile(r"\s*(?:(/\*.*?\*/)|(#define[^\n]*)|((?:enum|typedef struct \w+) \{.*?\n?\}[^;]*;(?:[ \t]*/\*.*?\*/)?)"
                       r"|(static inline .*?\n\})|([^;{]*;))", re.S)
    while body[position:].strip():
        match = token.match(body, position)
        if not match:
            raise ReferenceFault(f"not understood: {body[position:position + 80]!r}")
        position = match.end()
        if match.group(1):
            comment = match.group(1)
            continue
        yield comment, match.group().strip()
        comment = None


def name_of(code):
    define = re.match(r"#define (\w+)", code)
    if define:
        return define.group(1)
    if code.startswith("enum"):
        names = re.findall(ENUMERATOR, code)
        return names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}"
    structure = re.match(r"typedef struct (\w+)", code)
    if structure:
        return structure.group(1)
    return re.search(r"(\w+)\(", code).group(1)


def shown_code(code):
    code = re.sub(r"^FIRE3DV_API ", "", code)
    code = re.sub(r"^static inline (.*?\)) \{.*", r"static inline \1;", code, flags=re.S)
    return re.sub(r"\n {8,}", "\n    ", code) if "(" in code.split("\n")[0] and "{" not in code else code


def page_of(header):
    """Markdown of one header, and the public names on it."""
    text = read(f"{FOLDER}/{header}.h")
    opening = re.match(r"/\*.*?\*/", text, re.S).group()
    lines = comment_lines(opening)
    parts = [f"# fire3dv/{header}.h", prose_of(lines)]
    kinds = {"Types and constants": [], "Functions": []}
    names, before = [], None
    for comment, code in declarations(text):
        name = name_of(code)
        names += re.findall(ENUMERATOR, code) if code.startswith("enum") else [name]
        is_function = code.startswith(("FIRE3DV_API", "static"))
        explanation = prose_of(comment_lines(comment)) if comment else ""
        if not comment and is_function:
            if before is None:
                raise ReferenceFault(f"fire3dv/{header}.h: {name} has no comment")
            explanation = f"See [{before}](#{before.lower()})."
        if is_function and comment:
            before = name
        if re.fullmatch(r"typedef struct (\w+) \1;", code):
            explanation = "Opaque; the library owns its contents."
        section = "Functions" if is_function else "Types and constants"
        kinds[section].append(f"### {name}\n\n```c\n{shown_code(code)}\n```\n\n{explanation}".rstrip())
    declared = set(re.findall(r"FIRE3DV_API [^;]*?\b(fire3dv_\w+)\(", text)) | set(re.findall(r"^typedef struct (\w+)", text, re.M))
    missing = declared - set(names)
    if missing:
        raise ReferenceFault(f"fire3dv/{header}.h: not on its page: {', '.join(sorted(missing))}")
    for title, entries in kinds.items():
        if entries:
            parts += [f"## {title}", *entries]
    return "\n\n".join(parts) + "\n", names


def pages():
    """Markdown of all pages, by name below reference/c."""
    headers = sorted(name[:-2] for name in os.listdir(os.path.join(ROOT, FOLDER)) if name.endswith(".h"))
    if set(headers) != set(ORDER):
        raise ReferenceFault(f"headers {headers}: ORDER in tools/site_tools/c_reference.py lists others")
    result, rows = {}, []
    for header in ORDER:
        result[f"{header}.md"], names = page_of(header)
        purpose = re.match(r"/\* *(.*?)(?:: |\. )", read(f"{FOLDER}/{header}.h").replace("\n *", ""), re.S).group(1)
        functions = ", ".join(f"`{name}`" for name in names if name.startswith("fire3dv_") and f" {name}(" in result[f"{header}.md"])
        rows.append(f"| [{header}.h]({header}.md) | {purpose} | {functions} |")
    result["index.md"] = "\n".join([
        "# C and C++ reference", "",
        "The client library in C11, and the same for C++17 with RAII and exceptions, header only. They need no Vulkan.", "",
        "[Installation](../../docs/install.md#from-source), [an example](../../examples/client_c/README.md),",
        "[the same in Python](../python/index.md).", "",
        "| C | contents | functions |", "|---|---|---|", *rows, "",
        "| C++ | classes |", "|---|---|", "| [client.hpp](client_hpp.md) | `Stream`, `Description`, `Security`, `Image`, `ClientError` |",
        "| [joints.hpp](joints_hpp.md) | `Robot` |", ""])
    return result
