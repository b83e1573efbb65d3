"""Pages of the site: which Markdown files of the tree it has, and their groups."""
import fnmatch
import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
NAVIGATION = os.path.join(os.path.dirname(os.path.abspath(__file__)), "navigation.txt")
SKIPPED_FOLDERS = {"build", "demo-output", "__pycache__"}


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8", errors="replace") as file:
        return file.read()


def tree_files():
    """Names of all files of the tree, sorted: those that git knows or would add; in an archive without git, all."""
    if os.path.exists(os.path.join(ROOT, ".git")):
        listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z", "-co", "--exclude-standard"], capture_output=True, text=True, check=True)
        names = [name for name in listed.stdout.split("\0") if name]
    else:
        names = []
        for folder, folders, files in os.walk(ROOT):
            folders[:] = [each for each in folders if each not in SKIPPED_FOLDERS and not each.startswith(".")]
            names += [os.path.relpath(os.path.join(folder, file), ROOT) for file in files]
    return sorted({name for name in names if os.path.isfile(os.path.join(ROOT, name))})


class Group:
    """Heading of the navigation. entries: names of pages, or (title, [names]) of a folder with an index page of its own."""

    def __init__(self, title):
        self.title = title
        self.entries = []

    def pages(self):
        for entry in self.entries:
            yield from [entry] if isinstance(entry, str) else entry[1]


class Navigation:
    """Groups by navigation.txt, which explains itself. faults: pages in no group, and lines that it does not understand."""

    def __init__(self, files):
        self.groups, self.faults, self.omitted = [], [], []
        self.files = files
        left = [name for name in files if name.endswith(".md")]
        reference = ["reference/c/index.md", "reference/python/index.md"]  # made by c_reference.py, python_reference.py
        with open(NAVIGATION, encoding="utf-8") as file:
            lines = [line.rstrip() for line in file if line.strip() and not line.startswith("#")]
        for line in lines:
            if not line.startswith(" "):
                self.groups.append(Group(line))
                continue
            pattern, _, title = (part.strip() for part in line.partition(" = "))
            names = [name for name in left + reference if fnmatch.fnmatchcase(name, pattern) and self._same_depth(name, pattern)]
            left = [name for name in left if name not in names]
            if not self.groups:
                self.faults.append(f"navigation.txt: {line.strip()} stands before the first group")
            elif self.groups[-1].title == "(not in the site)":
                self.omitted += names
            elif title:
                if names:
                    self.groups[-1].entries.append((title, names))
            else:
                self.groups[-1].entries += names
        self.groups = [group for group in self.groups if group.entries]
        for name in left:
            self.faults.append(f"{name} is in no group of the site: add it to tools/site_tools/navigation.txt")

    @staticmethod
    def _same_depth(name, pattern):
        return name.count("/") == pattern.count("/")

    def pages(self):
        return [page for group in self.groups for page in group.pages()]
