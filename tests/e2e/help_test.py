"""Help of every installed program against its conventions: one line an option, 100 columns, no option without a word about it."""
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


for program in sys.argv[1:]:
    check(program.split(":"))
