#!/usr/bin/env python3
"""Output test of fire3dv-bench frame and images, on minimal scenes. It asserts no time."""
import csv
import os
import shlex
import subprocess
import sys

from harness import HANG_S, main, vulkan_environment
from image_reader import check, read_png

STAGES = ("poses", "TLAS", "cull", "raster", "shadow", "shading", "post")
CONDITIONS = ("product", "product, no shadows", "paper", "paper, no shadows")
SMALL = ("--resolution", "96x54", "--warm-up", "1", "--texture-size", "16", "--validation")


def bench(test, *arguments):
    return subprocess.run([test.programs_at["fire3dv-bench"], *arguments], capture_output=True, text=True,
                          timeout=HANG_S, env=vulkan_environment(), check=False)


def frame(test, out, *arguments):
    result = bench(test, "frame", "--out", out, *SMALL, *arguments)
    check(result.returncode == 0, f"ended with {result.returncode}:\n{result.stderr}")
    return result


def table(test):
    out = os.path.join(test.folder, "not", "there", "yet")
    result = frame(test, out, "--sizes", "5K,9K", "--frames", "3")
    check(result.stdout == os.path.join(out, "frame.md") + "\n", f"it does not say where: {result.stdout}")
    check(sorted(os.listdir(out)) == ["frame.csv", "frame.md"], f"wrote {os.listdir(out)}")

    with open(os.path.join(out, "frame.csv"), encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    check(all(None not in row and None not in row.values() for row in rows), "rows of the CSV file differ in length")
    of = {(row["scene"], row["condition"], row["quantity"]): row for row in rows}
    check(len(of) == len(rows), "a quantity stands twice")
    for scene, triangles in (("5K", 5000), ("9K", 9000)):
        for condition in CONDITIONS:
            whole = of[scene, condition, "whole frame"]
            check(abs(int(whole["triangles"]) - triangles) <= 0.01 * triangles, f"{scene}: {whole['triangles']} triangles")
            check(whole["count"] == "3" and float(whole["median"]) > 0, f"{scene}, {condition}: {whole}")
            check(float(whole["least"]) <= float(whole["median"]) <= float(whole["p95"]) <= float(whole["most"]), f"{whole}")
            for stage in STAGES:
                ran = float(of[scene, condition, stage]["most"]) > 0
                check(ran == (stage not in ("shadow", "TLAS") or "no shadows" not in condition), f"{scene}, {condition}: {stage} ran: {ran}")
            parts = sum(float(of[scene, condition, stage]["mean"]) for stage in (*STAGES, "TLAS wait", "GUI", "read-back", "between"))
            parts -= float(of[scene, condition, "side queue"]["mean"])
            by_stages = float(of[scene, condition, "frame by stages"]["mean"])
            check(abs(parts - by_stages) < 1e-3 * by_stages, f"{scene}, {condition}: {parts} of {by_stages}")
            for quantity in ("CPU", "pose age", "GPU memory", "process memory"):
                check(float(of[scene, condition, quantity]["median"]) > 0, f"{scene}, {condition}: no {quantity}")

    with open(os.path.join(out, "frame.md"), encoding="utf-8") as file:
        text = file.read()
    for word in ("fire3dv-bench frame --out", "Commit: ", "llvmpipe", "96x54, 4 samples", "3 frames after at least 1", "| 9K |"):
        check(word in text, f"the table lacks {word!r}:\n{text}")


def pictures(test):
    """Both raster paths draw the same scene, with the bodies at the poses of the first step."""
    images = []
    for raster in ("visibility", "forward"):
        frame(test, os.path.join(test.folder, raster), "--sizes", "5K", "--frames", "1", "--conditions", "product",
              "--raster", raster, "--image", test.folder, "--name", raster)
        images.append(read_png(os.path.join(test.folder, f"{raster}-5K.png")))
    check((images[0].width, images[0].height) == (96, 54), "not the size that was asked for")
    apart = [abs(a - b) for rows in zip(images[0].rows, images[1].rows) for a, b in zip(*rows)]
    check(sum(apart) / len(apart) < 1, f"the paths differ by {sum(apart) / len(apart):.2f} of 255 on average")
    colours = {images[0].pixel(x, y) for x in range(0, 96, 3) for y in range(0, 54, 3)}
    check(len(colours) > 50, f"the picture has {len(colours)} colours")


def images_of_a_file(test):
    png = os.path.join(test.folder, "last.png")
    result = bench(test, "images", test.scene, "--resolution", "160x90", "--frames", "3", "--warm-up", "1", "--png", png,
                   "--validation")
    check(result.returncode == 0, f"ended with {result.returncode}:\n{result.stderr}")
    cells = [cell.strip() for cell in result.stdout.strip().strip("|").split("|")]
    check(len(cells) == 10 and cells[0] == "FIRE-3DV" and cells[3:5] == ["160x90", "3"], f"no row of a table: {result.stdout}")
    check(all(float(cell) > 0 for cell in cells[5:]), f"{cells}")
    check(read_png(png).width == 160, "no picture")
    # At this aspect ratio the squares lie outside of the image, and an empty frame is fast.
    result = bench(test, "images", test.scene, "--resolution", "80x60")
    check(result.returncode == 1 and "blank" in result.stderr and result.stdout == "", f"{result}")


def bad_input(test):
    missing = os.path.join(test.folder, "missing.glb")
    in_a_file = os.path.join(test.scene, "folder")
    for code, words, arguments in (
            (2, ["name a command", "transport", "frame", "images"], []),
            (2, ["nonsense"], ["nonsense"]),
            (2, ["--sizes", "\"7G\"", "1K to 200M"], ["frame", "--sizes", "7G"]),
            (2, ["--sizes", "\"\""], ["frame", "--sizes", "1K,"]),
            (2, ["--resolution", "12"], ["frame", "--resolution", "12"]),
            (2, ["--resolution", "0x5"], ["images", test.scene, "--resolution", "0x5"]),
            (2, ["--frames"], ["frame", "--frames=0"]),
            (2, ["--frames"], ["frame", "--frames=-1"]),
            (2, ["--lights"], ["frame", "--lights", "many"]),
            (2, ["--name"], ["frame", "--name", "../x"]),
            (2, ["--texture-size"], ["frame", "--texture-size", "9999"]),
            (2, ["scene"], ["images"]),
            (2, ["rounds"], ["transport", "0"]),
            (1, [missing], ["images", missing]),
            (1, ["no such card", "llvmpipe"], ["frame", "--device", "no such card"]),
            (3, ["--require-gpu: no GPU can draw here", "llvmpipe"], ["frame", "--require-gpu"]),
            (1, ["--image", in_a_file], ["frame", "--image", in_a_file]),
            (1, ["--out", in_a_file], ["frame", "--out", in_a_file])):
        result = bench(test, *arguments)
        what = f"fire3dv-bench {' '.join(arguments)}: {result.returncode}\n{result.stderr}"
        check(result.returncode == code and result.stdout == "", what)
        check(all(word in result.stderr for word in words), f"lacks {words}: {what}")
        check(all(line.startswith(("fire3dv-bench: ", "  ")) for line in result.stderr.splitlines()), what)


def peers(test):
    """Tests the script that alternates with another program, here one that prints given text."""
    script = os.path.join(os.path.dirname(__file__), "..", "..", "tools", "lab", "bench", "scripts", "peers.py")
    log = os.path.join(test.folder, "log")

    def command(who, milliseconds):
        text = f"open({log!r},'a').write({who!r}); print('|p|{{scene}}|s|1x1|3|{milliseconds}|9|')"
        return f"{shlex.quote(sys.executable)} -c {shlex.quote(text)}"

    def compare(*arguments):
        return subprocess.run([sys.executable, script, "--scene", test.scene, *arguments], capture_output=True, text=True,
                              timeout=HANG_S, check=False)

    result = compare("--ours", command("a", 8), "--peer", command("b", 20), "--rounds", "3", "--name", "Other")
    check(result.returncode == 0, f"{result}")
    check(result.stdout.splitlines()[-1] == "| squares | 8.0 | 20.0 | 2.50 | 2.50 | 2.50 |", result.stdout)
    with open(log, encoding="utf-8") as file:
        check(file.read() == "ababab", "they do not take turns")
    ours = f"{test.programs_at['fire3dv-bench']} images {{scene}} --resolution 160x90 --frames 1 --warm-up 0"
    for value in ("row", "process"):
        result = compare("--ours", ours, "--peer", command("b", 20), "--rounds", "1", "--value", value)
        check(result.returncode == 0 and float(result.stdout.splitlines()[-1].split("|")[2]) > 0, f"{result}")
    for words, arguments in (
            (["lacks {scene}"], ["--ours", "true", "--peer", "true"]),
            (["no row"], ["--ours", "echo {scene}", "--peer", "true {scene}"]),
            (["no-such-program cannot be run"], ["--ours", "no-such-program {scene}", "--peer", "true {scene}"]),
            (["ended with 1"], ["--ours", "false {scene}", "--peer", "true {scene}"]),
            (["--rounds"], ["--ours", "a {scene}", "--peer", "b {scene}", "--rounds", "0"])):
        result = compare(*arguments)
        check(result.returncode != 0 and all(word in result.stderr for word in words), f"lacks {words}: {result}")
        check("Traceback" not in result.stderr, f"{result}")


CASES = {"table": table, "pictures": pictures, "images_of_a_file": images_of_a_file, "bad_input": bad_input,
         "peers": peers}

if __name__ == "__main__":
    main(CASES, ["fire3dv-bench"])
