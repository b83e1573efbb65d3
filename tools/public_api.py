#!/usr/bin/env python3
"""Public interface of the client library, held against stored lists: C declarations, names of the Python package.

    public_api.py --check   fails if declarations are new, changed or gone, or if one that is gone has no note
    public_api.py --write   stores what the sources have now

adapters/generic/api/c.txt and python.txt have a line for each declaration: the version that it came with, and the
declaration. What a version removes or changes keeps its line, FIRST-LAST, and needs its name in docs/upgrading.md. While
CHANGELOG.md says "## X.Y.0, not yet released", declarations that came with X.Y are changed without a trace.
"""
import argparse
import os
import re
import sys

from api_tools import c_header, python_package
import version

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LISTS = {"c.txt": c_header, "python.txt": python_package}
LINE = re.compile(r"(?P<first>\d+\.\d+)(?:-(?P<last>\d+\.\d+))? +(?P<text>\S.*)")


def stored(path):
    """(text, first, last) of each line; last is "" while the declaration lives."""
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8") as file:
        lines = [LINE.fullmatch(line.rstrip("\n")) for line in file if not line.startswith("#")]
    if not all(lines):
        sys.exit(f"public_api.py: {path} has a line that is no VERSION DECLARATION")
    return [(line["text"], line["first"], line["last"] or "") for line in lines]


def updated(before, texts, current, is_released):
    """What is to be stored; current: version in work, X.Y; is_released: X.Y.0 has been."""
    first = {text: since for text, since, last in before if not last}
    gone = [(text, since, last or current) for text, since, last in before if last or text not in texts]
    return ([(text, first.get(text, current), "") for text in texts] +
            [line for line in gone if is_released or line[1] != line[2]])


def differences(before, after, name_of, notes):
    for text, since, last in after:
        if (text, since, last) not in before:
            yield f"{'gone' if last else 'new'}: {text}"
        if last and name_of(text) not in notes:
            yield f"docs/upgrading.md does not mention {name_of(text)}, which {last} removes or changes: {text}"
    kept = {text for text, _, _ in after}
    yield from (f"gone, was never released: {text}" for text, _, _ in before if text not in kept)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    action = parser.add_mutually_exclusive_group(required=True)
    action.add_argument("--check", action="store_true")
    action.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    current = ".".join(version.stated(*version.SOURCE).split(".")[:2])
    is_released = not re.search(rf"(?m)^## {re.escape(current)}\.0, not yet released", version.read("CHANGELOG.md"))
    wrong = []
    for name, language in LISTS.items():
        path = os.path.join(ROOT, "adapters", "generic", "api", name)
        before = stored(path)
        after = updated(before, list(dict.fromkeys(language.public_interface(ROOT))), current, is_released)
        if arguments.write:
            with open(path, "w", encoding="utf-8") as file:
                file.write("# Public interface by version: written by tools/public_api.py --write.\n")
                file.writelines(f"{since + ('-' + last if last else ''):<9} {text}\n" for text, since, last in after)
            before = after
        wrong += differences(before, after, language.name_of, version.read("docs/upgrading.md"))
    if wrong:
        print("\n".join(wrong))
        print("public_api.py: the public interface is not the stored one. If that is meant: tools/public_api.py --write")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
