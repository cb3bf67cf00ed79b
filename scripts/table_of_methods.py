#!/usr/bin/env python3
"""Makes of what `tamis experiment methods` prints the tables of docs/best.md and docs/experiments.md.

    tamis experiment methods SCENE… FOLDER… --spp 8,32,128,512 --oidn "python scripts/denoise_with_oidn.py" -o DIR
    python scripts/table_of_methods.py DIR/methods.md [--spp 32,128,512]

Errors are over those of Open Image Denoise, with noisy or denoised albedo and normal, or over those of the best rival, OIDN
included: error by error whichever is better. First a row for each scene, cross rMSE / the same without the worst 0.1 % of
pixels by number of samples; then geometric means (FLIP, too) over the renders with the numbers of `--spp`, and over those and
the folders' stacks; last, the energy of `best` where it is more than 1 % off. Needs nothing else.
"""

import argparse
import math
import re
import sys

import tables

MEASURES = ["cross rMSE", "trimmed", "FLIP"]
SHOWN = ["whole", "best"]
JUDGED = ["best", "whole", "fast"]
OIDN = ["oidn", "oidn-clean"]
RIVALS = ["wlr", "wlrp", "wlrv", "nfor", "apr", "lbf", *OIDN]
RENDER = re.compile(r"(.+)-(\d+)spp-\d+$")


def read_rows(path):
    """By stack and method: cross rMSE, trimmed, FLIP, energy."""
    found = {}
    for cells in tables.lines_of_cells(path):
        if len(cells) == 8 and cells[1] in {"ld", "paper", *JUDGED, *RIVALS}:
            values = [math.nan if cell == "-" else float(cell) for cell in [*cells[2:5], cells[6]]]
            found.setdefault(cells[0], {})[cells[1]] = values
    if not found:
        sys.exit(f"{path}: expected the table of `tamis experiment methods`")
    if not any(method in OIDN for methods in found.values() for method in methods):
        sys.exit(f"{path}: no row of OIDN: run the experiment with --oidn")
    return found


def over(methods, method, rivals, measure):
    """One error of a method over the least of the rivals'; a rival whose error is not above 0, by chance, does not count."""
    errors = [methods[rival][measure] for rival in rivals if rival in methods]
    return methods[method][measure] / min(error for error in errors if error > 0)


def ratio(value):
    return f"{value:.2f}".removeprefix("0")


def cell(stacks, method, rivals, measures):
    """Errors of several measures, geometric means over the stacks."""
    means = (tables.geometric_mean([over(methods, method, rivals, measure) for methods in stacks]) for measure in measures)
    return " / ".join(ratio(mean) for mean in means)


def print_table(head, rows):
    print(tables.head(head))
    for row in rows:
        print(tables.line(row))
    print()


def by_scene(renders):
    """A row for each scene and one for all: `whole` and `best` by number of samples."""
    scenes, counts = list(dict.fromkeys(scene for scene, _ in renders)), sorted({spp for _, spp in renders})
    groups = [(scene, [scene]) for scene in scenes] + [("**geometric mean**", scenes)]

    def stacks(names, spp):
        return [methods for name in names for methods in renders.get((name, spp), [])]

    head = ["scene", *(f"{spp} spp, {method}" for spp in counts for method in SHOWN)]
    cells = [
        [cell(stacks(names, spp), method, OIDN, [0, 1]) if stacks(names, spp) else "-" for spp in counts for method in SHOWN]
        for _, names in groups
    ]
    print_table(head, [[label, *row] for (label, _), row in zip(groups, cells)])


def means(label, stacks):
    """Rows of the means of each of our methods, with the three largest trimmed errors."""
    for method in JUDGED:
        trimmed = sorted(((over(methods, method, OIDN, 1), name) for name, methods in stacks.items()), reverse=True)
        worst = ", ".join(f"{ratio(value)} ({name})" for value, name in trimmed[:3])
        errors = [cell(stacks.values(), method, rivals, [0, 1, 2]) for rivals in (OIDN, RIVALS)]
        yield [f"{method}, {label}: {len(stacks)}", *errors, worst]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", metavar="methods.md")
    parser.add_argument("--spp", default="32,128,512", metavar="N,N…", help="renders that the means count [default: 32,128,512]")
    options = parser.parse_args()
    found = read_rows(options.table)
    wanted = [int(spp) for spp in options.spp.split(",")]
    renders, counted, folders = {}, {}, {}
    for name, methods in found.items():
        match = RENDER.match(name)
        if match is None:
            folders[name] = methods
            continue
        scene, spp = match[1], int(match[2])
        renders.setdefault((scene, spp), []).append(methods)
        if spp in wanted:
            counted[name] = methods
    if renders:
        by_scene(renders)
    groups = [(label, stacks) for label, stacks in (("renders", counted), ("folders", folders)) if stacks]
    if counted and folders:
        groups.append(("renders and folders", counted | folders))
    head = ["", "over OIDN's", "over the best rival's, OIDN included", "largest trimmed over OIDN's"]
    print_table(head, [row for label, stacks in groups for row in means(label, stacks)])
    off = [(name, methods) for name, methods in (counted | folders).items() if abs(methods["best"][3] - 1) > 0.01]
    energies = [[name, *(f"{methods[who][3]:.4g}" if who in methods else "-" for who in ("best", *OIDN))] for name, methods in off]
    print_table(["energy off by more than 1 %", "best", *OIDN], energies)


if __name__ == "__main__":
    main()
