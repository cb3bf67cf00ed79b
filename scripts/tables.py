"""What scripts share that make tables of what `tamis experiment` prints. Plain Python, no packages."""

import math
import sys


def lines_of_cells(path):
    """The cells of every line of a file of tables; what is no line of a table has a single one."""
    try:
        with open(path, encoding="utf-8") as file:
            lines = file.read().splitlines()
    except OSError as error:
        sys.exit(f"{path}: {error.strerror}")
    return [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in lines]


def geometric_mean(values):
    """That of numbers above 0; where one is not, there is none."""
    return math.exp(sum(map(math.log, values)) / len(values)) if min(values) > 0 else math.nan


def line(cells):
    return "| " + " | ".join(cells) + " |"


def head(cells):
    """The first two lines of a table."""
    return line(cells) + "\n|" + "---|" * len(cells)
