#!/usr/bin/env python3
"""Renders every file below the folders given, whole or broken, and says what became of each.

    python3 scripts/render_all_scenes.py FOLDER... [--tamis target/debug/tamis] [--limit SECONDS]
    python3 scripts/render_all_scenes.py FOLDER... --size 256 --spp 16 --sheets DIR       (needs pillow)

A file must be rendered (exit code 0), or refused in one line that names it (exit code 2); all else is a fault, and then the
script exits with 1. Files that are neither scenes nor look like ones (pictures, licences …) are left out.

`--sheets` puts the pictures side by side, with their names, to be looked at: what is flipped, black or out of sight is seen by
nothing else.
"""

import argparse
import collections
import pathlib
import subprocess
import sys
import tempfile
import time

SCENES = {".obj", ".toml", ".gltf", ".glb", ".txt"}


def outcome(args, file, output):
    """What became of `file`: a word, seconds, and what was said."""
    size = f"{args.size}x{args.size}"
    command = [args.tamis, "render", file, "--size", size, "--spp", str(args.spp), "-o", output]
    start = time.time()
    try:
        run = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=args.limit)
    except subprocess.TimeoutExpired:
        return "HANGS", args.limit, ""
    seconds = time.time() - start
    errors = [line for line in run.stderr.splitlines() if line.startswith("error:")]
    if run.returncode == 0:
        notes = [line for line in run.stderr.splitlines() if "left out" in line or "missing" in line or "ignored" in line]
        return "rendered", seconds, f"{len(notes)} notes" if notes else ""
    if run.returncode == 2 and len(errors) == 1 and str(file) in errors[0] and len(run.stderr.splitlines()) < 5:
        return "refused", seconds, errors[0].removeprefix("error: ").replace(str(file), file.name)
    return f"FAULT {run.returncode}", seconds, run.stderr.strip().replace("\n", " / ")[-300:]


COLUMNS, ROWS, LABEL = 5, 4, 14


def write_sheets(folder, pictures):
    """Contact sheets of (name, picture) pairs."""
    from PIL import Image, ImageDraw

    folder.mkdir(parents=True, exist_ok=True)
    of_each = COLUMNS * ROWS
    for first in range(0, len(pictures), of_each):
        shown = pictures[first : first + of_each]
        side = Image.open(shown[0][1]).width
        rows = -(-len(shown) // COLUMNS)
        sheet = Image.new("RGB", (COLUMNS * side, rows * (side + LABEL)))
        for i, (name, picture) in enumerate(shown):
            x, y = i % COLUMNS * side, i // COLUMNS * (side + LABEL)
            sheet.paste(Image.open(picture).convert("RGB"), (x, y + LABEL))
            ImageDraw.Draw(sheet).text((x + 2, y + 1), str(name)[-side // 6 :], fill="white")
        sheet.save(folder / f"sheet{first // of_each + 1}.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    parser.add_argument("--tamis", default="target/debug/tamis")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds after which a render counts as hung")
    parser.add_argument("--size", type=int, default=32, help="width and height of the pictures")
    parser.add_argument("--spp", type=int, default=1)
    parser.add_argument("--sheets", type=pathlib.Path, help="folder of contact sheets")
    args = parser.parse_args()
    counts, pictures = collections.Counter(), []
    print("| file | outcome | seconds | |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for root in args.folders:
            files = sorted(f for f in root.rglob("*") if f.is_file() and f.suffix.lower() in SCENES)
            for file in files:
                picture = f"{folder}/{counts.total()}.png"
                word, seconds, said = outcome(args, file, picture)
                counts[word] += 1
                pictures += [(file.relative_to(root), picture)] if word == "rendered" else []
                print(f"| {file.relative_to(root)} | {word} | {seconds:.1f} | {said} |", flush=True)
        if args.sheets and pictures:
            write_sheets(args.sheets, pictures)
    print(", ".join(f"{count} {word}" for word, count in counts.most_common()))
    return int(any(word not in ("rendered", "refused") for word in counts))


if __name__ == "__main__":
    sys.exit(main())
