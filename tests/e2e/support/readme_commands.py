"""Reads the shell commands that a document shows, so that tests run what users copy."""
import re
import shlex

from image_reader import check


def code_blocks(text, language):
    """Returns the texts of the fenced blocks of a language ("sh", "python", "c") in a Markdown text, in order."""
    return re.findall(rf"^```{re.escape(language)}\n(.*?)^```", text, re.S | re.M)


def section_of(path, heading):
    """Returns the text under a heading of second level of a Markdown file, up to the next one."""
    with open(path, encoding="utf-8") as file:
        parts = file.read().split(f"\n## {heading}\n", 1)
    check(len(parts) == 2, f"{path} has no section {heading!r}")
    return parts[1].split("\n## ", 1)[0]


def commands_of(path, heading):
    """Returns the words of each command in the section's sh blocks; a backslash at a line's end continues it."""
    lines = "\n".join(code_blocks(section_of(path, heading), "sh")).replace("\\\n", " ").splitlines()
    found = [words for words in map(shlex.split, lines) if words]
    check(found, f"{path}: section {heading!r} has no commands")
    return found
