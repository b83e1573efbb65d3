"""Folder that Sphinx builds the site from: the pages of the tree at their own paths, with links that hold there.

README.md becomes index.md. Files and folders that pages link to become pages below files/, the public headers those of
reference/c. Manual pages lose their title block and get a title.
"""
import json
import os
import posixpath
import re
import shutil

from . import c_reference, cpp_reference, markdown, python_reference
from .pages import ROOT, Navigation, read, tree_files

IMAGES = (".png", ".svg", ".jpg", ".webp")
LANGUAGES = {".py": "python", ".c": "c", ".h": "c", ".hpp": "cpp", ".cpp": "cpp", ".sh": "bash", ".sbatch": "bash", ".json": "json",
             ".xml": "xml", ".sdf": "xml", ".urdf": "xml", ".yaml": "yaml", ".yml": "yaml", ".cmake": "cmake"}
MAX_FILE_BYTES = 200_000


class Stage:
    """Staged pages by path: the text of each."""

    def __init__(self):
        self.files = set(tree_files())
        self.folders = {posixpath.dirname(name) for name in self.files}
        self.folders |= {parent for folder in list(self.folders) for parent in parents_of(folder)}
        self.navigation = Navigation(sorted(self.files))
        self.faults = list(self.navigation.faults)
        self.pages, self.images, self.children = {}, set(), {}
        self.indices = {}  # folder: its index page
        for group in self.navigation.groups:
            for entry in group.entries:
                if not isinstance(entry, str):
                    self.indices[posixpath.commonpath([posixpath.dirname(name) for name in entry[1]])] = entry
        self._waiting = []
        self._add_reference("reference/c", {**c_reference.pages(), **cpp_reference.pages()})
        self._add_reference("reference/python", python_reference.pages())
        for name in self.navigation.pages():
            if name not in self.pages:
                self._add(staged(name), name, page_text(name))
        for folder, (title, names) in self.indices.items():
            self._add_index(folder, title, names)
        while self._waiting:
            self._add_file(self._waiting.pop())

    def _add(self, path, source, text):
        """source: the file of the tree whose folder the links are relative to."""
        parts, end = [], 0
        for start, stop, target in markdown.links(text):
            parts += [text[end:start], self._moved(target, source, path)]
            end = stop
        self.pages[path] = "".join(parts) + text[end:]

    def _moved(self, target, source, path):
        """The target of a link of a source file, as the staged page needs it."""
        if re.match(r"[a-z][a-z0-9+.-]*:", target):
            return target
        place, _, anchor = target.partition("#")
        name = posixpath.normpath(posixpath.join(posixpath.dirname(source), place)) if place else source
        found = self._place_of(name, source, target) if place else path
        return posixpath.relpath(found, posixpath.dirname(path) or ".") + (f"#{anchor}" if anchor else "")

    def _place_of(self, name, source, target):
        if name.startswith("reference/"):
            return name
        if name.startswith(c_reference.FOLDER) and name.endswith((".h", ".hpp")):
            return f"reference/c/{posixpath.basename(name).removesuffix('.h').replace('.', '_')}.md"
        if name in self.files:
            if name.endswith(IMAGES):
                self.images.add(name)
                return name
            if name.endswith(".md") and name not in self.navigation.omitted:
                return staged(name)
            return self._file_page(name)
        if name in self.folders:
            if name in self.indices:
                return f"{name}/index.md"
            return staged(f"{name}/README.md") if f"{name}/README.md" in self.files else self._file_page(name)
        self.faults.append(f"{source}: {target} leads nowhere")
        return name

    def _file_page(self, name):
        path = f"files/{name}/index.md" if name in self.folders else f"files/{name}.md"
        if path not in self.pages:
            self.pages[path] = ""
            self._waiting.append(name)
        return path

    def _add_file(self, name):
        if name in self.folders:
            inside = sorted({"/".join(part for part in each[len(name) + 1:].partition("/")[:2] if part) for each in self.files
                             if each.startswith(name + "/")})
            text = f"# {name}\n\nFolder of the source tree.\n\n" + "\n".join(f"- `{each}`" for each in inside) + "\n"
            self._add(f"files/{name}/index.md", f"{name}/README.md", text)
            return
        content = read(name)
        if len(content) > MAX_FILE_BYTES or "\0" in content:
            content = "This file is in the source tree.\n"
        language = LANGUAGES.get(posixpath.splitext(name)[1], "text")
        self.pages[f"files/{name}.md"] = f"# {name}\n\nFile of the source tree.\n\n``````{language}\n{content.rstrip()}\n``````\n"

    def _add_reference(self, folder, made):
        for name, text in made.items():
            self._add(f"{folder}/{name}", f"{folder}/{name}", text)
        self.children[f"{folder}/index.md"] = [name for name in made if name != "index.md"]

    def _add_index(self, folder, title, names):
        rows = []
        for name in names:
            text = self.pages[staged(name)]
            rows.append(f"- [{markdown.title_of(text, name)}]({posixpath.relpath(staged(name), folder)}): {summary(text)}")
        self.pages[f"{folder}/index.md"] = f"# {title}\n\n" + "\n".join(rows) + "\n"
        self.children[f"{folder}/index.md"] = [posixpath.relpath(staged(name), folder) for name in names]

    def paths_of(self, group):
        """Staged pages of a group, those below index pages left out."""
        for entry in group.entries:
            if isinstance(entry, str):
                yield staged(entry)
            else:
                yield next(f"{folder}/index.md" for folder, each in self.indices.items() if each is entry)

    def navigation_of_pages(self):
        """Groups, pages and the pages below them, as the template of the pages reads them."""
        def entry(path):
            below = [posixpath.join(posixpath.dirname(path), child) for child in self.children.get(path, [])]
            return {"name": path[:-3], "title": markdown.title_of(self.pages[path], path), "pages": [entry(each) for each in below]}
        return [{"title": group.title, "pages": [entry(path) for path in self.paths_of(group)]} for group in self.navigation.groups]

    def write(self, folder):
        """Writes what Sphinx reads. Its own tables of contents are not used: no page is in one."""
        for path, text in self.pages.items():
            write(os.path.join(folder, path), f"---\norphan: true\n---\n\n{text}")
        write(os.path.join(folder, "navigation.json"), json.dumps(self.navigation_of_pages()))
        self._write_images(folder)

    def write_markdown(self, folder):
        """Writes each page as Markdown beside its HTML page, the images that it shows, and llms.txt."""
        for path, text in self.pages.items():
            write(os.path.join(folder, path), text)
        self._write_images(folder)
        write(os.path.join(folder, "llms.txt"), self.llms_text())

    def _write_images(self, folder):
        for name in self.images:
            os.makedirs(os.path.join(folder, posixpath.dirname(name)), exist_ok=True)
            shutil.copyfile(os.path.join(ROOT, name), os.path.join(folder, name))

    def llms_text(self):
        """Index of all pages, one line each (llmstxt.org)."""
        lines = ["# FIRE-3DV", "", f"> {summary(self.pages['index.md'])}", "",
                 "Each page of this site is also Markdown: PAGE.md beside PAGE.html."]
        for group in self.navigation.groups:
            lines += ["", f"## {group.title}", ""]
            for path in self.paths_of(group):
                lines.append(self._line(path))
                lines += [self._line(posixpath.join(posixpath.dirname(path), child)) for child in self.children.get(path, [])]
        lines += ["", "## Optional", ""]
        lines += [self._line(path) for path in sorted(self.pages) if path.startswith("files/")]
        return "\n".join(lines) + "\n"

    def _line(self, path):
        text = self.pages[path]
        purpose = "" if path.startswith("files/") else summary(text)
        return f"- [{markdown.title_of(text, path)}]({path})" + (f": {purpose}" if purpose else "")


def parents_of(folder):
    while folder:
        folder = posixpath.dirname(folder)
        if folder:
            yield folder


def staged(name):
    return "index.md" if name == "README.md" else name


def page_text(name):
    text = read(name)
    manual = re.match(r"% .*\n+# NAME\n+([\w-]+)(?:, [\w-]+)* - (.*)\n", text)
    if not manual:
        return text
    section = posixpath.basename(name).split(".")[-2]
    body = text[manual.end():].lstrip("\n")
    starts = {start for _, _, start in markdown.headings(body)}
    body = "".join(("#" if offset in starts else "") + body[offset:stop] for offset, stop in spans(sorted(starts | {0}), len(body)))
    return f"# {manual.group(1)}({section})\n\n{manual.group(2)[0].upper()}{manual.group(2)[1:]}.\n\n{body}"


def spans(starts, end):
    return zip(starts, [*starts[1:], end])


def summary(text):
    return markdown.first_sentence(text).rstrip(".")


def write(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
