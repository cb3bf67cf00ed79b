#!/usr/bin/env python3
"""Renders every file below the folders given, whole or broken, and says what became of each.

    python3 scripts/render_all_scenes.py FOLDER... [--tamis target/debug/tamis] [--limit SECONDS]

A file must be rendered (exit code 0), or refused in one line that names it (exit code 2); all else is a fault, and then the
script exits with 1. Files that are neither scenes nor look like ones (pictures, licences …) are left out.
"""

import argparse
import collections
import pathlib
import subprocess
import sys
import tempfile
import time

SCENES = {".obj", ".toml", ".gltf", ".glb", ".txt"}


def outcome(tamis, file, output, limit):
    """What became of `file`: a word, seconds, and what was said."""
    command = [tamis, "render", file, "--size", "32x32", "--spp", "1", "-o", output]
    start = time.time()
    try:
        run = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=limit)
    except subprocess.TimeoutExpired:
        return "HANGS", limit, ""
    seconds = time.time() - start
    errors = [line for line in run.stderr.splitlines() if line.startswith("error:")]
    if run.returncode == 0:
        notes = [line for line in run.stderr.splitlines() if "left out" in line or "missing" in line or "ignored" in line]
        return "rendered", seconds, f"{len(notes)} notes" if notes else ""
    if run.returncode == 2 and len(errors) == 1 and str(file) in errors[0] and len(run.stderr.splitlines()) < 5:
        return "refused", seconds, errors[0].removeprefix("error: ").replace(str(file), file.name)
    return f"FAULT {run.returncode}", seconds, run.stderr.strip().replace("\n", " / ")[-300:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    parser.add_argument("--tamis", default="target/debug/tamis")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds after which a render counts as hung")
    args = parser.parse_args()
    counts = collections.Counter()
    print("| file | outcome | seconds | |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for root in args.folders:
            files = sorted(f for f in root.rglob("*") if f.is_file() and f.suffix.lower() in SCENES)
            for file in files:
                word, seconds, said = outcome(args.tamis, file, f"{folder}/x.exr", args.limit)
                counts[word] += 1
                print(f"| {file.relative_to(root)} | {word} | {seconds:.1f} | {said} |", flush=True)
    print(", ".join(f"{count} {word}" for word, count in counts.most_common()))
    return int(any(word not in ("rendered", "refused") for word in counts))


if __name__ == "__main__":
    sys.exit(main())
