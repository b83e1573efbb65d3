"""C++ reference as Markdown, one page for each header-only class header of the client library: its declarations without bodies.

The comments of the header stay where they are. Private members are left out.
"""
import os
import re

from .c_reference import FOLDER, ReferenceFault, escaped, prose_of
from .pages import ROOT, read

HEADERS = ("client", "joints")


def matching_brace(text, start):
    """The offset behind the brace that closes the one at start. Comments and literals of the headers hold no lone brace."""
    depth = 0
    for offset in range(start, len(text)):
        depth += {"{": 1, "}": -1}.get(text[offset], 0)
        if depth == 0:
            return offset + 1
    raise ReferenceFault(f"no brace closes {text[start:start + 60]!r}")


def without_bodies(text):
    """Bodies of functions, with the initialisers of constructors, become a semicolon."""
    parts, position = [], 0
    for match in re.finditer(r"//[^\n]*|\{", text):
        if match.start() < position or match.group() != "{" or text.startswith("= {}", match.start() - 2):
            continue
        before = text[position:match.start()]
        statement = re.split(r"[;}]|\n\n|//[^\n]*\n|public:", before)[-1]
        if re.search(r"\b(class|struct|enum|namespace)\b[^()]*$", statement):
            parts.append(text[position:match.end()])
            position = match.end()
            continue
        cut = re.sub(r"\s+:\s+[\w:]+\(.*$", "", statement, flags=re.S)
        parts.append(before[:len(before) - len(statement)] + cut.rstrip() + ";")
        position = matching_brace(text, match.start())
    return "".join(parts) + text[position:]


def page_of(header):
    text = read(f"{FOLDER}/{header}.hpp")
    opening = re.match(r"(?://[^\n]*\n)+", text).group()
    lines = [re.sub(r"^// ?", "", line) for line in opening.rstrip("\n").split("\n")]
    body = text[text.index("namespace fire3dv {") + len("namespace fire3dv {"):text.rindex("}  // namespace fire3dv")]
    body = re.sub(r"\n+ private:.*?(?=\n\};)", "", without_bodies(body), flags=re.S)
    parts = [f"# fire3dv/{header}.hpp", prose_of(lines).replace("```c\n", "```cpp\n")]
    for declaration in re.split(r"\n\n(?=(?://[^\n]*\n)*(?:class|struct) )", body.strip()):
        name = re.search(r"^(?:class|struct) (\w+)", declaration, re.M)
        comment = re.match(r"(?://[^\n]*\n)+(?=class|struct)", declaration)
        explanation = escaped(" ".join(line[3:] for line in comment.group().rstrip("\n").split("\n"))) if comment else ""
        code = declaration[comment.end():] if comment else declaration
        if not name:
            parts.append("```cpp\n" + code.strip() + "\n```")
            continue
        if not comment:
            raise ReferenceFault(f"fire3dv/{header}.hpp: {name.group(1)} has no comment")
        body_end = code.index("\n};") + 3
        parts += [f"## {name.group(1)}", explanation, "```cpp\n" + code[:body_end].strip() + "\n```"]
        rest = code[body_end:].strip()
        if rest:
            parts.append("```cpp\n" + rest + "\n```")
    return "\n\n".join(part for part in parts if part) + "\n"


def pages():
    """Markdown of all pages, by name below reference/c."""
    there = {name[:-4] for name in os.listdir(os.path.join(ROOT, FOLDER)) if name.endswith(".hpp")}
    if there != set(HEADERS):
        raise ReferenceFault(f"headers {sorted(there)}: HEADERS in tools/site_tools/cpp_reference.py lists others")
    return {f"{header}_hpp.md": page_of(header) for header in HEADERS}
