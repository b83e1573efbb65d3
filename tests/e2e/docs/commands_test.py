"""Command lines in the documents: each option of our programs is one that the program's --help has.

commands_test.py PROGRAM[:SUBCOMMAND]...; programs that are not given are not checked.
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


def options_of(words):
    text = subprocess.run([*words, "--help"], capture_output=True, text=True, timeout=60, check=True).stdout
    return set(re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", text)) | {"--help", "-h", "--version"}


def faults_of(line, command, options, place):
    """Sentences on the options of one command. Words before the program, such as sudo or VARIABLE=VALUE, do not matter."""
    words = command.split()
    at = next((i for i, word in enumerate(words) if os.path.basename(word) in options), None)
    if at is None or not all(re.match(r"\w+=|(sudo|exec|time|timeout|nohup|env|\d+)$", word) for word in words[:at]):
        return
    program = os.path.basename(words[at])
    known, subcommands = options[program]
    behind = words[at + 1:]
    if behind and behind[0] in subcommands:
        known = subcommands[behind[0]] | (known if behind[0] == "render" else set())  # it takes the renderer's options, too
    quoted = False
    for word in behind:
        if not quoted and re.match(r"--?[a-zA-Z]", word):
            name = re.match(r"--?[a-zA-Z][\w-]*", word).group()
            if name not in known and not re.fullmatch(r"-?[A-Z-]+", name):
                yield f"{place}:{line}: {program} has no option {name}: {command}"
        if (word.count("'") + word.count('"')) % 2:
            quoted = not quoted


def main():
    options = {}
    for argument in sys.argv[1:]:
        path, _, subcommand = argument.partition(":")
        entry = options.setdefault(os.path.basename(path), (set(), {}))
        if subcommand:
            entry[1][subcommand] = options_of([path, subcommand])
        else:
            entry[0].update(options_of([path]))
    faults, checked = [], 0
    for name in tree_files():
        if name.endswith(".md") and name not in HISTORY:
            for line, command in markdown.commands(read(name)):
                checked += any(os.path.basename(word) in options for word in command.split()[:1])
                faults += faults_of(line, command, options, name)
    for fault in faults:
        print(fault)
    print(f"{checked} commands of {len(options)} programs, {len(faults)} faults")
    return 1 if faults or checked < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
