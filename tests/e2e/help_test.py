"""Command lines of every installed program: help with one line an option and 100 columns, --version, and suggestions
for unknown options.
"""
import re
import subprocess
import sys


def check(command):
    result = subprocess.run([*command, "--help"], capture_output=True, text=True, timeout=60)
    name = " ".join([command[0].rsplit("/", 1)[-1], *command[1:]])
    assert result.returncode == 0, f"{name} --help exits with {result.returncode}"
    assert result.stderr == "", f"{name} --help writes to stderr: {result.stderr}"
    lines = result.stdout.split("\n")
    assert any(line.startswith("Usage: ") for line in lines), f"{name}: no usage line"
    options = 0
    for line in lines:
        assert len(line) <= 100, f"{name}: {len(line)} columns: {line}"
        if not re.match(r"  -", line):
            continue
        options += 1
        assert re.match(r"  (-\w, )?--[\w-]+( \S+)*\s+\S", line), f"{name}: no description: {line}"
        assert not re.search(r"\b(tells|gives|lets)\b", line), f"{name}: a vague verb: {line}"
    assert options >= 1, f"{name}: {options} options in\n{result.stdout}"
    print(f"{name}: {options} options")


def check_version(program):
    result = subprocess.run([program, "--version"], capture_output=True, text=True, timeout=60)
    name = program.rsplit("/", 1)[-1]
    assert result.returncode == 0 and result.stderr == "", f"{name} --version: {result}"
    assert re.fullmatch(rf"{name} \d+\.\d+\.\d+ \(commit \S+\)\n\S.*\n", result.stdout), result.stdout


def check_suggestion(program):
    """An option with two letters swapped is unknown, and the option is suggested. Exit status 2, whatever else is missing."""
    name = program.rsplit("/", 1)[-1]
    result = subprocess.run([program, "--hlep"], capture_output=True, text=True, timeout=60)
    assert result.returncode == 2 and result.stdout == "", f"{name} --hlep: {result}"
    assert "unknown option --hlep, did you mean --help?" in result.stderr, result.stderr
    assert result.stderr.startswith(f"{name}: error: ") and result.stderr.count("\n") == 1, result.stderr
    result = subprocess.run([program, "--quite-another-option"], capture_output=True, text=True, timeout=60)
    assert result.returncode == 2 and "unknown option --quite-another-option" in result.stderr, result.stderr
    assert "did you mean" not in result.stderr, result.stderr


def check_commands(program):
    """A mistyped command is no scene."""
    for words, hint in ((["datset", "x.glb"], "did you mean \"dataset\"?"), (["train"], "there are \"dataset\", \"doctor\", \"join\"")):
        result = subprocess.run([program, *words], capture_output=True, text=True, timeout=60)
        assert result.returncode == 2 and f"there is no command and no file \"{words[0]}\"; {hint}" in result.stderr, result.stderr


for program in sys.argv[1:]:
    check(program.split(":"))
    if ":" not in program:
        check_version(program)
        check_suggestion(program)
    if program.rsplit("/", 1)[-1] == "fire3dv":
        check_commands(program)
