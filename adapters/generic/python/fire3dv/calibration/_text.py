"""Readers of the YAML and XML that calibration programs write: names, lists and numbers. No other tags, references or aliases."""
from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Any, List, Optional, Tuple

_MAX_DEPTH = 16


class FileFault(ValueError):
    """Text that is not of this kind; says the line."""


def _scalar(text: str) -> Any:
    text = text.strip()
    if len(text) > 1 and text[0] == text[-1] and text[0] in "\"'":
        return text[1:-1]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return {"": None, "~": None, "null": None, "true": True, "false": False, ".nan": float("nan"), ".NaN": float("nan"),
            ".inf": float("inf"), ".Inf": float("inf"), "-.inf": float("-inf"), "-.Inf": float("-inf")}.get(text, text)


def _flow(text: str, at: int, line: int, depth: int) -> Tuple[List[Any], int]:
    """List from the bracket at `at`; returns the place behind it."""
    if depth > _MAX_DEPTH:
        raise FileFault(f"line {line}: lists within more than {_MAX_DEPTH} lists")
    items: List[Any] = []
    begin = at = at + 1
    while at < len(text):
        if text[at] == "[":
            if text[begin:at].strip():
                break
            nested, at = _flow(text, at, line, depth + 1)
            items.append(nested)
            begin = at
        elif text[at] in ",]":
            rest = text[begin:at].strip()
            if rest:
                items.append(_scalar(rest))
            if text[at] == "]":
                return items, at + 1
            at += 1
            begin = at
        else:
            at += 1
    raise FileFault(f"line {line}: a list that does not end")


def _without_comment(text: str) -> str:
    quote = ""
    for i, character in enumerate(text):
        if quote:
            quote = "" if character == quote else quote
        elif character in "\"'":
            quote = character
        elif character == "#" and (i == 0 or text[i - 1] in " \t"):
            return text[:i]
    return text


class _Yaml:
    def __init__(self, text: str) -> None:
        self.lines: List[Tuple[int, int, str]] = []  # number, indentation, text
        for number, raw in enumerate(text.splitlines(), 1):
            line = _without_comment(raw).rstrip()
            if not line.strip() or line.startswith(("%", "---", "...")):
                continue
            if "\t" in line[:len(line) - len(line.lstrip())]:
                raise FileFault(f"line {number} is indented by a tab")
            self.lines.append((number, len(line) - len(line.lstrip()), line.strip()))
        self.next = 0

    def value(self, text: str, number: int, indentation: int, depth: int) -> Any:
        """Value behind a name or a dash, which are at this indentation."""
        if text.startswith("!!"):
            text = text.partition(" ")[2].strip()  # !!opencv-matrix
        if text.startswith("["):
            while True:
                try:
                    items, end = _flow(text, 0, number, depth)
                    break
                except FileFault:
                    if self.next == len(self.lines) or text.count("[") <= text.count("]"):
                        raise
                    text += " " + self.lines[self.next][2]
                    self.next += 1
            if text[end:].strip():
                raise FileFault(f"line {number}: text behind a list")
            return items
        if text[:1] in "{&*|>":
            if text:
                raise FileFault(f"line {number}: {text[0]} is not supported")
            return self.block(indentation, depth + 1)
        return _scalar(text)

    def block(self, above: int, depth: int) -> Any:
        """Block that is indented more than `above`; None: there is none. Lists may be as far as their name."""
        if depth > _MAX_DEPTH:
            raise FileFault(f"line {self.lines[self.next - 1][0]}: more than {_MAX_DEPTH} levels")
        if self.next == len(self.lines):
            return None
        _, indentation, text = self.lines[self.next]
        is_list = text == "-" or text.startswith("- ")
        if indentation < above or (indentation == above and not is_list):
            return None
        return self.items(indentation, depth) if is_list else self.names(indentation, depth)

    def items(self, indentation: int, depth: int) -> List[Any]:
        items: List[Any] = []
        while self.next < len(self.lines):
            number, at, text = self.lines[self.next]
            if at != indentation or not (text == "-" or text.startswith("- ")):
                break
            rest = text[1:].strip()
            if rest == "-" or rest.startswith("- ") or self._name(rest):
                self.lines[self.next] = (number, at + len(text) - len(text[1:].lstrip()), rest)
                items.append(self.block(at, depth + 1))
            else:
                self.next += 1
                items.append(self.value(rest, number, at, depth))
        return items

    @staticmethod
    def _name(text: str) -> Optional[Tuple[str, str]]:
        name, colon, rest = text.partition(":")
        if not colon or (rest and not rest.startswith((" ", "\t"))) or name.startswith("[") or not name.strip():
            return None
        return name.strip().strip("\"'"), rest.strip()

    def names(self, indentation: int, depth: int) -> Any:
        values = {}
        while self.next < len(self.lines):
            number, at, text = self.lines[self.next]
            if at != indentation:
                if at > indentation:
                    raise FileFault(f"line {number} is indented more than the one before it")
                break
            named = self._name(text)
            if not named:
                raise FileFault(f"line {number} is no `name: value`")
            self.next += 1
            values[named[0]] = self.value(named[1], number, at, depth)
        return values


def parse_yaml(text: str) -> Any:
    yaml = _Yaml(text)
    root = yaml.block(-1, 0)
    if yaml.next < len(yaml.lines):
        raise FileFault(f"line {yaml.lines[yaml.next][0]} is indented less than the first one")
    return root


def parse_xml(text: str) -> Any:
    """FileStorage of OpenCV: elements by name; matrices have `data`."""
    if "<!" in text.replace("<!--", ""):
        raise FileFault("declarations and entities are not supported")  # they can grow without bounds
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as fault:
        raise FileFault(str(fault)) from None
    if root.tag != "opencv_storage":
        raise FileFault(f"its root is <{root.tag[:40]}>, not <opencv_storage>")

    def value(element: ElementTree.Element) -> Any:
        if element.get("type_id") == "opencv-matrix":
            return {child.tag: [_scalar(word) for word in (child.text or "").split()] if child.tag == "data" else child.text
                    for child in element}
        words = (element.text or "").split()
        return [_scalar(word) for word in words] if len(words) > 1 else _scalar(element.text or "")

    return {child.tag: value(child) for child in root}
