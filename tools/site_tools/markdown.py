"""Markdown files of the tree: links, headings and anchors, without a Markdown library.

Understands what the documents use: fenced and indented code, code spans, inline links and images, # headings.
"""
import re

FENCE = re.compile(r"^ {0,3}(`{3,}|~{3,})(.*)$")
LINK = re.compile(r"\]\(\s*<?([^()<>\s]*(?:\([^()\s]*\)[^()\s]*)*)>?(?:\s+\"[^\"]*\")?\s*\)")
CODE_SPAN = re.compile(r"(?<!`)(`+)(?!`)((?:(?!\n\n).)*?)(?<!`)\1(?!`)", re.S)
HEADING = re.compile(r"^(#{1,6}) +(.*?)(?: +#+)? *$", re.M)
HTML_ANCHOR = re.compile(r"<a\s+(?:id|name)=\"([^\"]+)\"")
LIST_ITEM = re.compile(r"^ *(?:[-*+]|\d+[.)]) ")


def blank(text):
    """Spaces of the same length, lines kept, so that offsets stay valid."""
    return re.sub(r"[^\n]", " ", text)


def without_blocks(text):
    """The text with fenced and indented code blanked."""
    lines, fence, in_list, before_is_blank, in_code = [], None, False, True, False
    for line in text.split("\n"):
        match = FENCE.match(line.lstrip() if in_list else line)
        if fence:
            lines.append(blank(line))
            if match and match.group(1).startswith(fence) and not match.group(2).strip():
                fence = None
            continue
        if match:
            fence = match.group(1)
            lines.append(blank(line))
            continue
        if line.strip():
            in_code = line.startswith("    ") and not in_list and (before_is_blank or in_code)
            if not line.startswith(" "):
                in_list = bool(LIST_ITEM.match(line))
            elif not in_code and LIST_ITEM.match(line):
                in_list = True
        before_is_blank = not line.strip()
        lines.append(blank(line) if in_code else line)
    return "\n".join(lines)


def prose(text):
    """The text with all code blanked."""
    return CODE_SPAN.sub(lambda match: blank(match.group()), without_blocks(text))


def commands(text):
    """Yields (line number, command) of shell lines in code blocks without language or of a shell, and of code spans. Lines
    that end with a backslash go on; commands behind a pipe, a semicolon or && are ones of their own."""
    blocks = code_blocks(text)
    spans = [(match.start(), match.group(2)) for match in CODE_SPAN.finditer(without_blocks(text))]
    for offset, code in sorted(blocks + spans):
        line = text.count("\n", 0, offset) + 1
        for row in re.sub(r"\\\n", "\0", code).split("\n"):
            joined = re.sub(r"(^|\s)#.*", "", row.replace("\0", " "))
            for part in re.split(r"\|\||&&|[|;&]|\$\(|`", joined):
                if part.strip():
                    yield line, part.strip()
            line += 1 + row.count("\0")


def code_blocks(text, languages=("", "sh", "bash", "console")):
    """(offset, text) of each fenced block of these languages; indented blocks have no language."""
    found, rest = [], without_blocks(text)
    lines, position, fence, start = text.split("\n"), 0, None, 0
    rest_lines = rest.split("\n")
    for line, kept in zip(lines, rest_lines):
        match = FENCE.match(line.strip())
        if not kept.strip() and line.strip():
            if match and fence is None:
                fence, start = match.group(2).strip(), position + len(line) + 1
            elif match and not match.group(2).strip() and fence is not None:
                if fence in languages:
                    found.append((start, text[start:position]))
                fence = None
            elif fence is None and "" in languages:
                found.append((position, line + "\n"))
        position += len(line) + 1
    return joined_blocks(found)


def joined_blocks(found):
    """Blocks of one line that follow each other, as indented code is read, made one."""
    result = []
    for offset, code in found:
        if result and result[-1][0] + len(result[-1][1]) == offset:
            result[-1] = (result[-1][0], result[-1][1] + code)
        else:
            result.append((offset, code))
    return result


def links(text):
    """Yields (start, end, target) of each inline link and image."""
    for match in LINK.finditer(prose(text)):
        yield match.start(1), match.end(1), match.group(1)


def plain(title):
    """A heading without its inline markup."""
    title = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", title)
    return re.sub(r"[`*]|\\(?=[^\w\s])", "", title).strip()


def headings(text):
    """Yields (level, title without markup, offset) of each heading."""
    for match in HEADING.finditer(without_blocks(text)):
        yield len(match.group(1)), plain(text[match.start(2):match.end(2)]), match.start()


def slug(title):
    """Anchor of a heading as forges and the site make it."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def anchors(text):
    """Names that links to parts of the document may have."""
    found, counts = set(HTML_ANCHOR.findall(prose(text))), {}
    for _, title, _ in headings(text):
        name = slug(title)
        number = counts.get(name, 0)
        counts[name] = number + 1
        found.add(f"{name}-{number}" if number else name)
    return found


def title_of(text, fallback):
    return next((title for level, title, _ in headings(text) if level == 1), fallback)


def first_sentence(text):
    """The first sentence below the title, without markup: a description of the page."""
    body = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text, flags=re.S)
    body = re.sub(r"<!--.*?-->", "", body, flags=re.S)
    body = "\n".join(line for line in without_blocks(body).split("\n") if not line.startswith(("#", "%", "|", ">")))
    paragraph = next((part for part in re.split(r"\n\s*\n", body) if re.search(r"\w", part) and not LIST_ITEM.match(part.lstrip("\n"))), "")
    paragraph = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", paragraph, flags=re.S)
    paragraph = re.sub(r"\s+", " ", re.sub(r"\*\*|`", "", paragraph)).strip()
    return re.split(r"(?<=[.:?!]) ", paragraph)[0].rstrip(":")
