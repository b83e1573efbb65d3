"""Command lines in the documents: each option of our programs is one that the program's --help has.

commands_test.py PROGRAM...; programs that are not given are not checked.
"""
import os
import re
import subprocess
import sys

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
sys.path.insert(0, os.path.join(ROOT, "tools"))

from site_tools import markdown  # noqa: E402
from site_tools.pages import read, tree_files  # noqa: E402

HISTORY = ("CHANGELOG.md", "docs/upgrading.md", "docs/design/experiments.md")  # options that there were


class Program:
    """Options of a program by its --help, and of its subcommands by theirs."""

    def __init__(self, path):
        self.path = path
        self._known = {}

    def options(self, subcommand=None):
        """A word that is no subcommand gets the program's own options: it is a file, or its help fails."""
        if subcommand not in self._known:
            done = subprocess.run([self.path, *([subcommand] if subcommand else []), "--help"], capture_output=True, text=True,
                                  timeout=60, check=False, cwd="/")
            listed = set(re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", done.stdout)) | {"--help", "-h", "--version"}
            self._known[subcommand] = listed if done.returncode == 0 else self.options()
            if subcommand in ("render", "dataset", "relabel", "verify"):  # they take the renderer's options, too
                self._known[subcommand] |= self.options()
            if subcommand == "relabel":
                self._known[subcommand] |= self.options("dataset")
        return self._known[subcommand]


def faults_of(line, command, programs, place):
    """Sentences on the options of one command. Words before the program, such as sudo or VARIABLE=VALUE, do not matter."""
    words = command.split()
    at = next((i for i, word in enumerate(words) if os.path.basename(word) in programs), None)
    if at is None or not all(re.match(r"\w+=|(sudo|exec|time|timeout|nohup|env|\d+)$", word) for word in words[:at]):
        return
    program, behind = os.path.basename(words[at]), words[at + 1:]
    known = programs[program].options(behind[0] if behind and re.fullmatch(r"[a-z][a-z-]*", behind[0]) else None)
    quoted = False
    for word in behind:
        if not quoted and re.match(r"--?[a-zA-Z]", word):
            name = re.match(r"--?[a-zA-Z][\w-]*", word).group()
            if name not in known and not re.fullmatch(r"-?[A-Z-]+", name):
                yield f"{place}:{line}: {program} has no option {name}: {command}"
        if (word.count("'") + word.count('"')) % 2:
            quoted = not quoted


def main():
    programs = {os.path.basename(path): Program(path) for path in sys.argv[1:]}
    faults, checked = [], 0
    for name in tree_files():
        if name.endswith(".md") and name not in HISTORY:
            for line, command in markdown.commands(read(name)):
                checked += any(os.path.basename(word) in programs for word in command.split()[:1])
                faults += faults_of(line, command, programs, name)
    for fault in faults:
        print(fault)
    print(f"{checked} commands of {len(programs)} programs, {len(faults)} faults")
    return 1 if faults or checked < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
