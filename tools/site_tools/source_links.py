"""Relative links and anchors of the tree's Markdown files."""
import posixpath
import re

from . import markdown
from .pages import read


def faults_of_tree(files, folders):
    """Sentences on links that lead to no file, folder or heading of the tree."""
    texts = {name: read(name) for name in sorted(files) if name.endswith(".md")}
    anchors = {name: markdown.anchors(text) for name, text in texts.items()}
    faults = []
    for name, text in texts.items():
        for start, _, target in markdown.links(text):
            if re.match(r"[a-z][a-z0-9+.-]*:", target):
                continue
            place, _, anchor = target.partition("#")
            found = posixpath.normpath(posixpath.join(posixpath.dirname(name), place)) if place else name
            line = text.count("\n", 0, start) + 1
            if found not in files and found not in folders and found != ".":
                faults.append(f"{name}:{line}: {target} leads nowhere")
            elif anchor and anchor not in anchors.get(found, ()):
                faults.append(f"{name}:{line}: {target}: no heading of {found} has this anchor")
    return faults
