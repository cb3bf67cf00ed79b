#!/usr/bin/env python3
"""Error of a hall under 1,000 small lamps, over that of the same hall under one panel, at equal samples.

    pip install numpy openexr                         (tried with numpy 2, openexr 3.5)
    python scripts/many_lamps.py                      (half a minute)

The hall is 40 × 25 units of floor with a block in every other cell, so that lamps throw shadows; a second one has
partitions between all cells, so that almost nothing but a cell's own lamp reaches its floor, which no choice of lamps
can know. Lamps hang at height 1.2, one to a cell, a tenth of a unit wide, with powers that differ by a factor of up to
ten. The panel hangs in their plane, fills it, and sends as much light in all. Only light that arrives directly is
traced (--max-depth 1), since more bounces would add the same noise to both.

Printed is the relative error of a picture, √mean(variance ÷ mean²) over pixels, from the spread between independent
seeds. The exit status is 1 when the lamps' is more than 1.5 times the panel's.
"""

import argparse
import math
import os
import random
import sys
import tempfile

from packages import need

need(__doc__, "numpy", "OpenEXR")

import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402
from measuring import call  # noqa: E402

WIDTH, DEPTH, HEIGHT = 40, 25, 1.2
LAMP = 0.1
LIMIT = 1.5


class Obj:
    """Collects quads by material and writes them as OBJ and MTL."""

    def __init__(self):
        self.lines, self.vertices, self.materials = ["mtllib hall.mtl"], 0, ["newmtl grey\nKd 0.6 0.6 0.6"]

    def quads(self, material, quads):
        self.lines.append(f"usemtl {material}")
        for quad in quads:
            self.lines += ["v {:.6g} {:.6g} {:.6g}".format(*corner) for corner in quad]
            n = self.vertices
            self.lines.append(f"f {n + 1} {n + 2} {n + 3} {n + 4}")
            self.vertices += 4

    def lamp(self, name, radiance, quad):
        self.materials.append(f"newmtl {name}\nKd 0 0 0\nKe {radiance:.6g} {radiance:.6g} {radiance:.6g}")
        self.quads(name, [quad])

    def write(self, folder):
        with open(os.path.join(folder, "hall.mtl"), "w") as file:
            file.write("\n".join(self.materials) + "\n")
        path = os.path.join(folder, "hall.obj")
        with open(path, "w") as file:
            file.write("\n".join(self.lines) + "\n")
        return path


def block(x, z, half, height):
    """The sides and the top of a block."""
    x0, x1, z0, z1 = x - half[0], x + half[0], z - half[1], z + half[1]
    corners = [(x0, z1), (x1, z1), (x1, z0), (x0, z0)]
    edges = zip(corners, corners[1:] + corners[:1])
    sides = [[(*a, 0), (*b, 0), (*b, height), (*a, height)] for a, b in edges]
    top = [(*corner, height) for corner in corners]
    return [[(x, y, z) for x, z, y in quad] for quad in [*sides, top]]


def facing_down(x0, x1, z0, z1):
    return [(x0, HEIGHT, z0), (x1, HEIGHT, z0), (x1, HEIGHT, z1), (x0, HEIGHT, z1)]


def hall(folder, partitions, panel):
    """Writes a hall, under a panel or under lamps; returns its path."""
    obj, chance = Obj(), random.Random(1)
    obj.quads("grey", [[(0, 0, DEPTH), (WIDTH, 0, DEPTH), (WIDTH, 0, 0), (0, 0, 0)]])
    cells = [(x + 0.5, z + 0.5) for x in range(WIDTH) for z in range(DEPTH)]
    for x, z in cells:
        if (int(x) + int(z)) % 2 == 0:
            obj.quads("grey", block(x + 0.25, z + 0.2, (0.12, 0.12), 0.3))
        if partitions:
            obj.quads("grey", block(x - 0.5, z, (0.01, 0.5), HEIGHT - 0.05))
            obj.quads("grey", block(x, z - 0.5, (0.5, 0.01), HEIGHT - 0.05))
    radiances = [10.0 ** chance.uniform(1.0, 2.0) for _ in cells]
    if panel:
        mean = sum(radiances) * LAMP * LAMP / (WIDTH * DEPTH)
        obj.lamp("panel", mean, facing_down(0, WIDTH, 0, DEPTH))
    else:
        for i, ((x, z), radiance) in enumerate(zip(cells, radiances)):
            x, z = x + chance.uniform(-0.3, 0.3), z + chance.uniform(-0.3, 0.3)
            obj.lamp(f"lamp{i}", radiance, facing_down(x - LAMP / 2, x + LAMP / 2, z - LAMP / 2, z + LAMP / 2))
    return obj.write(folder)


def picture(options, scene, seed, folder):
    path = os.path.join(folder, "picture.exr")
    command = [options.tamis, "render", scene, "--uniform", "--no-denoise", "--quiet", "--aov", "none"]
    command += ["--max-depth=1", f"--seed={seed}", f"--spp={options.spp}", "--size=128x96", "-o", path]
    command += ["--eye=20,6,31", "--look-at=20,0,14", "--fov=50"]
    call(command)
    channels = OpenEXR.File(path, separate_channels=True).channels()
    return channels["G"].pixels.astype(np.float64)


def relative_error(options, partitions, panel):
    with tempfile.TemporaryDirectory() as folder:
        scene = hall(folder, partitions, panel)
        pictures = np.stack([picture(options, scene, seed, folder) for seed in range(options.seeds)])
    # Pixels without light say nothing about sampling.
    mean, variance = pictures.mean(axis=0), pictures.var(axis=0, ddof=1)
    lit = mean > 0.0
    return math.sqrt((variance[lit] / mean[lit] ** 2).mean())


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spp", type=int, default=16, help="of each seed")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--tamis", default="target/debug/tamis")
    return parser.parse_args()


def main():
    options, worst = parse_options(), 0.0
    print("| hall | one panel | 1,000 lamps | ratio |\n|---|---|---|---|")
    for partitions in (False, True):
        panel = relative_error(options, partitions, True)
        lamps = relative_error(options, partitions, False)
        worst = max(worst, lamps / panel)
        print(f"| {'with partitions' if partitions else 'open'} | {panel:.3f} | {lamps:.3f} | {lamps / panel:.2f} |")
    sys.exit(0 if worst <= LIMIT else 1)


if __name__ == "__main__":
    main()
