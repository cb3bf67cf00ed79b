#!/usr/bin/env python3
"""Makes of what `tamis experiment degrade` prints the table of docs/denoise.md: errors over Open Image Denoise's by level.

    tamis experiment degrade FOLDER… -o DIR
    python scripts/table_of_levels.py DIR/degrade.md [--stacks NAME,NAME… --stacks NAME…]

Each cell is cross rMSE / the same without the worst 0.1 % of pixels, over those of OIDN from the same picture, geometric
mean over the stacks of a group; all stacks are one group without `--stacks`. Every stack needs oidn.exr and oidn-colour.exr
in its folder when the experiment runs; `python scripts/guide_stacks.py FOLDER…` puts them there. Needs nothing else.
"""

import argparse
import sys

import tables

METHODS = ["best", "nfor", "wlr", "apr", "paper"]
OIDN = "oidn"


def read_rows(path):
    """Cross rMSE, trimmed and energy by (stack, level, method), and levels and stacks in their order."""
    found = {}
    for cells in tables.lines_of_cells(path):
        if len(cells) == 7 and cells[2] in [*METHODS, OIDN]:
            found[tuple(cells[:3])] = tuple(float(cell) for cell in cells[3:6])
    if not found:
        sys.exit(f"{path}: expected the table of `tamis experiment degrade`")
    return found


def ratios(found, stacks, level, method):
    """Errors and trimmed errors over OIDN's, of every stack."""
    try:
        own, others = ([found[stack, level, who] for stack in stacks] for who in (method, OIDN))
    except KeyError as missing:
        stack, level, who = missing.args[0]
        sys.exit(f"{stack}, {level}: no row of {who}" + (": are oidn.exr and oidn-colour.exr in its folder?" if who == OIDN else ""))
    return ([mine[i] / other[i] for mine, other in zip(own, others)] for i in (0, 1))


def row(found, stacks, level):
    means = [[tables.geometric_mean(part) for part in ratios(found, stacks, level, method)] for method in METHODS]
    cells = [" / ".join(f"{value:.3g}" for value in pair) for pair in means]
    worst = max(list(ratios(found, stacks, level, "best"))[1])
    energies = [found[stack, level, "best"][2] for stack in stacks]
    return [level, *cells, f"{worst:.3g}", f"{min(energies):.3f}–{max(energies):.3f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", metavar="degrade.md")
    parser.add_argument("--stacks", action="append", metavar="NAME,NAME…", help="a group of stacks; may be given again")
    options = parser.parse_args()
    found = read_rows(options.table)
    groups = [group.split(",") for group in options.stacks or []] or [list(dict.fromkeys(key[0] for key in found))]
    for stack in [stack for group in groups for stack in group if not any(key[0] == stack for key in found)]:
        sys.exit(f"{options.table}: no stack called {stack}")
    head = ["what is left", *METHODS, "best ÷ OIDN, worst stack, trimmed", "energy of best"]
    print(tables.head(head))
    for stacks in groups:
        # Stacks that know nothing of their noise have no row of the richer levels.
        levels = dict.fromkeys(key[1] for key in found if key[0] in stacks)
        for level in [level for level in levels if all((stack, level, "best") in found for stack in stacks)]:
            print(tables.line(row(found, stacks, level)))


if __name__ == "__main__":
    main()
