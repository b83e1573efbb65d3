#!/usr/bin/env python3
"""Completions for bash, zsh and fish, generated from the --help of programs.

    completions.py --bash DIR --zsh DIR --fish DIR PROGRAM[:SUBCOMMAND...] ...

The help has one line for each option: names, value, and from column 30 its meaning (base/command_line.h).
"""
import argparse
import os
import re
import subprocess
from typing import List, NamedTuple

COLUMN = 30
URIS = ["shm://", "tcp://", "tls://", "udp://"]


class Option(NamedTuple):
    names: List[str]
    value: str          # as in the help; empty for a flag
    text: str
    words: List[str]    # possible values, where the help lists them
    kind: str           # "flag", "words", "uri", "file", "folder" or "other"


def option_of(line):
    """Returns the option of a line of help, None for other lines."""
    if not re.match(r"  --?\w", line):
        return None
    left, text = (line[:COLUMN], line[COLUMN:]) if line[COLUMN - 1:COLUMN] == " " else re.split(r"(?<=\S)  +", line, maxsplit=1)
    names, value = re.fullmatch(r"((?:-\w, )?--[\w-]+) ?(.*)", left.strip()).groups()
    return Option(names.split(", "), value, text.strip(), words_of(value, text), kind_of(value, words_of(value, text)))


def words_of(value, text):
    if re.fullmatch(r"[a-z0-9-]+(\|[a-z0-9-]+)+", value):
        return value.split("|")
    if value in ("NAME", "MODE"):  # "h264 (default), h265, or ffv1 (.mkv)", "raster path: auto, forward or visibility"
        listed = re.search(r"((?:[a-z0-9-]+, )+)([a-z0-9-]+ )*(?:or )(?:\w+ )?([a-z0-9-]+)$", re.sub(r" \([^)]*\)", "", text))
        if listed:
            before = re.sub(r"^.*[:] |^by ", "", listed.group(0))
            return [word for word in re.findall(r"[a-z0-9-]+", before) if word not in ("or", "lossless")]
    return []


def kind_of(value, words):
    if not value:
        return "flag"
    if words:
        return "words"
    if value.startswith("URI"):
        return "uri"
    if re.search(r"FILE|OUT|VIDEO|PROGRAM|\.\w+$", value):
        return "file"
    return "folder" if value == "DIR" else "other"


def options_of(command):
    output = subprocess.run([*command, "--help"], check=True, capture_output=True, text=True).stdout
    found = [option for option in map(option_of, output.split("\n")) if option]
    if not found:
        raise SystemExit(f"completions.py: {' '.join(command)} --help lists no options")
    return found


def quoted(text):
    return "'" + text.replace("'", "'\\''") + "'"


def bash_cases(options):
    """Cases of the word before the cursor."""
    actions = {"words": lambda option: f"COMPREPLY=($(compgen -W {quoted(' '.join(option.words))} -- \"$cur\"))",
               "uri": lambda option: f"COMPREPLY=($(compgen -W {quoted(' '.join(URIS))} -- \"$cur\")); compopt -o nospace",
               "file": lambda option: "mapfile -t COMPREPLY < <(compgen -f -- \"$cur\"); compopt -o filenames",
               "folder": lambda option: "mapfile -t COMPREPLY < <(compgen -d -- \"$cur\"); compopt -o filenames",
               "other": lambda option: "COMPREPLY=()"}
    names_of = {}
    for option in options:
        if option.kind != "flag":
            names_of.setdefault(actions[option.kind](option), []).extend(option.names)
    return [f"    {'|'.join(names)}) {action}; return ;;" for action, names in names_of.items()]


def bash(name, commands):
    function = "_" + re.sub(r"\W", "_", name)
    lines = [f"# Completion of {name}, generated from its --help.", f"{function}() {{",
             "  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} options=",
             "  # \":\" and \"=\" separate words in bash: the parts of a URI are left to the user.",
             "  [[ $prev == [:=] || $cur == [:=] ]] && return"]
    subcommands = [sub for sub in commands if sub]
    lines.append("  case ${COMP_WORDS[1]} in")
    for sub, options in sorted(commands.items(), reverse=True):
        words = " ".join(each for option in options for each in option.names)
        lines += [f"  {sub or '*'})", "    case $prev in", *bash_cases(options), "    esac", f"    options={quoted(words)} ;;"]
    lines += ["  esac", "  if [[ $cur == -* ]]; then COMPREPLY=($(compgen -W \"$options\" -- \"$cur\")); return; fi",
              "  mapfile -t COMPREPLY < <(compgen -f -- \"$cur\"); compopt -o filenames"]
    if subcommands:
        lines.append(f"  [ \"$COMP_CWORD\" != 1 ] || COMPREPLY+=($(compgen -W {quoted(' '.join(subcommands))} -- \"$cur\"))")
    return "\n".join([*lines, "}", f"complete -F {function} {name}", ""])


def zsh_argument(option):
    actions = {"words": f":value:({' '.join(option.words)})", "uri": f":URI:({' '.join(URIS).replace(':', chr(92) + ':')})",
               "file": ":file:_files", "folder": ":folder:_files -/", "other": ":value: ", "flag": ""}
    text = re.sub(r"([\[\]:\\])", r"\\\1", option.text)
    repeat = "*" if "repeatable" in option.text else ""
    return [quoted(f"{repeat}{name}[{text}]{actions[option.kind]}") for name in option.names]


def zsh(name, commands):
    lines = [f"#compdef {name}", f"# Completion of {name}, generated from its --help.", "case ${words[2]} in"]
    for sub, options in sorted(commands.items(), reverse=True):
        arguments = [argument for option in options for argument in zsh_argument(option)]
        lines += [f"{sub or '*'})", "  _arguments \\", *[f"    {argument} \\" for argument in arguments]]
        subcommands = "" if sub else " ".join(each for each in commands if each)
        first = f"    '1:command or file:{{ compadd {subcommands}; _files }}' \\" if subcommands else None
        lines += [*([first] if first else []), "    '*:file:_files' ;;"]
    return "\n".join([*lines, "esac", ""])


def fish(name, commands):
    lines = [f"# Completion of {name}, generated from its --help."]
    subcommands = [sub for sub in commands if sub]
    if subcommands:
        lines.append(f"complete -c {name} -n __fish_use_subcommand -a {quoted(' '.join(subcommands))}")
    seen = f"__fish_seen_subcommand_from {' '.join(subcommands)}"
    for sub, options in sorted(commands.items()):
        when = f"-n '__fish_seen_subcommand_from {sub}' " if sub else f"-n 'not {seen}' " if subcommands else ""
        for option in options:
            names = " ".join(f"-l {each[2:]}" if each.startswith("--") else f"-s {each[1:]}" for each in option.names)
            value = {"flag": "", "file": " -r -F", "folder": " -x -a '(__fish_complete_directories)'", "other": " -x",
                     "words": f" -x -a {quoted(' '.join(option.words))}", "uri": f" -x -a {quoted(' '.join(URIS))}"}[option.kind]
            lines.append(f"complete -c {name} {when}{names}{value} -d {quoted(option.text)}")
    return "\n".join([*lines, ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    shells = {"bash": ("{}", bash), "zsh": ("_{}", zsh), "fish": ("{}.fish", fish)}
    for shell in shells:
        parser.add_argument(f"--{shell}", metavar="DIR")
    parser.add_argument("programs", nargs="+", metavar="PROGRAM[:SUBCOMMAND...]")
    args = parser.parse_args()
    for entry in args.programs:
        program, *subcommands = entry.split(":")
        name = os.path.basename(program)
        commands = {sub: options_of([program, *([sub] if sub else [])]) for sub in ["", *subcommands]}
        for shell, (file_name, text_of) in shells.items():
            folder = getattr(args, shell)
            if folder:
                os.makedirs(folder, exist_ok=True)
                with open(os.path.join(folder, file_name.format(name)), "w", encoding="utf-8") as file:
                    file.write(text_of(name, commands))


if __name__ == "__main__":
    main()
