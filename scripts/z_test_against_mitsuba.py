#!/usr/bin/env python3
"""Twelve small scenes rendered by Tamis and by Mitsuba 3, and a Z-test of every pixel.

    pip install mitsuba numpy openexr pillow          (tried with mitsuba 3.9, numpy 2, openexr 3.5, pillow 13)
    python scripts/z_test_against_mitsuba.py -o DIR   (some ten minutes; --only NAME for one scene)

Each scene is written as OBJ, MTL and pictures, rendered by both with `--seeds` independent seeds, and must pass what
Mitsuba asks of itself (mitsuba3, src/render/tests/test_renders.py): with z the difference over its standard error, where
the variance of a sample is taken for 10⁻⁴ at least, no less than 99.75 % of the pixels' channels may have a p-value
above the Šidák-corrected level 1 − (1 − 0.01)^(1/pixels). Mitsuba takes its reference for free of noise; here both
pictures have some, so the standard error is that of both. That test forgives a bias smaller than the noise, so the mean
of the picture must agree within 0.5 % besides, or within three standard errors where noise leaves more than that open.

Printed, too, is the root mean square of z, 1 by chance: it shows a bias in many pixels that no single one shows. DIR gets
the scenes, and both pictures of each side by side with their difference. The exit status is 1 when a scene fails.
"""

import argparse
import math
import os
import sys

from packages import need

need(__doc__, "numpy", "OpenEXR", "PIL", "mitsuba")

import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402
from both_renderers.comparison import mean_and_error, write_side_by_side  # noqa: E402
from both_renderers.renders import render_with_mitsuba, render_with_tamis  # noqa: E402
from both_renderers.view import View  # noqa: E402
from PIL import Image  # noqa: E402

SIGNIFICANCE = 0.01
LEAST_SHARE = 0.9975
MEAN_TOLERANCE = 0.005


# --- Scenes -----------------------------------------------------------------------------------------------------------


class Scene:
    """Writes an OBJ file with its MTL, piece by piece."""

    def __init__(self, folder, name):
        self.folder, self.name = folder, name
        self.lines, self.materials = [f"mtllib {name}.mtl"], []
        self.counts = [0, 0, 0]

    def material(self, name, statements):
        self.materials.append(f"newmtl {name}\n{statements}")
        return name

    def quad(self, material, corner, a, b):
        """A parallelogram whose front is the side a × b points to, with uvs 0 … 1."""
        corner, a, b = np.array(corner, float), np.array(a, float), np.array(b, float)
        points = [corner, corner + a, corner + a + b, corner + b]
        self.lines.append(f"usemtl {material}")
        self.lines += ["v {:.7g} {:.7g} {:.7g}".format(*p) for p in points]
        self.lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
        p, t = self.counts[0], self.counts[1]
        self.lines.append("f " + " ".join(f"{p + i}/{t + i}" for i in (1, 2, 3, 4)))
        self.counts[0] += 4
        self.counts[1] += 4

    def sphere(self, material, centre, radius, rows=96):
        """With normals, and facets so fine that those hardly differ from the facets' own."""
        columns = 2 * rows
        angles = [(math.pi * r / rows, 2 * math.pi * c / columns) for r in range(rows + 1) for c in range(columns)]
        normals = [(math.sin(t) * math.cos(p), math.cos(t), math.sin(t) * math.sin(p)) for t, p in angles]
        self.lines.append(f"usemtl {material}")
        for n in normals:
            self.lines.append("v {:.7g} {:.7g} {:.7g}".format(*(c + radius * x for c, x in zip(centre, n))))
            self.lines.append("vn {:.7g} {:.7g} {:.7g}".format(*n))
        p, n = self.counts[0] + 1, self.counts[2] + 1

        def corner(row, column):
            i = row * columns + column % columns
            return f"{p + i}//{n + i}"

        for r in range(rows):
            for c in range(columns):
                a, b, d, e = corner(r, c), corner(r, c + 1), corner(r + 1, c), corner(r + 1, c + 1)
                self.lines += [f"f {a} {b} {e}"] if r > 0 else []
                self.lines += [f"f {a} {e} {d}"] if r < rows - 1 else []
        self.counts[0] += len(normals)
        self.counts[2] += len(normals)

    def write(self):
        path = os.path.join(self.folder, f"{self.name}.obj")
        for ending, lines in (("obj", self.lines), ("mtl", self.materials)):
            with open(os.path.join(self.folder, f"{self.name}.{ending}"), "w") as file:
                file.write("\n".join(lines) + "\n")
        return path

    def view(self, **changes):
        return View(self.write(), eye=[0.6, 2.0, 6.5], look_at=[0.0, 0.9, 0.0], fov=32.0, size=SIZE, **changes)


SIZE = [64, 48]


def stage(folder, name, lamp=True):
    """Floor and two walls, and a lamp overhead."""
    scene = Scene(folder, name)
    scene.material("floor", "Kd 0.5 0.5 0.5")
    scene.material("red", "Kd 0.6 0.2 0.1")
    scene.material("green", "Kd 0.2 0.5 0.2")
    scene.quad("floor", (-3, 0, 3), (6, 0, 0), (0, 0, -6))
    scene.quad("red", (-3, 0, 3), (0, 0, -6), (0, 4, 0))
    scene.quad("green", (-3, 0, -3), (6, 0, 0), (0, 4, 0))
    if lamp:
        scene.material("lamp", "Kd 0 0 0\nKe 8 7 6")
        scene.quad("lamp", (-1, 3.9, -1), (2, 0, 0), (0, 0, 2))
    return scene


def with_sphere(folder, name, statements, **changes):
    scene = stage(folder, name)
    scene.sphere(scene.material("sphere", statements), (0.2, 1.0, 0.3), 1.0)
    return scene.view(**changes)


def diffuse(folder):
    return with_sphere(folder, "diffuse", "Kd 0.7 0.6 0.3")


def coated(folder):
    return with_sphere(folder, "coated", "Kd 0.5 0.2 0.1\nKs 0.04 0.04 0.04\nPr 0.5")


def rough_conductor(folder):
    return with_sphere(folder, "rough conductor", "Kd 0.9 0.7 0.4\nPm 1\nPr 0.6")


def smooth_conductor(folder):
    return with_sphere(folder, "smooth conductor", "Kd 0 0 0\nKs 0.9 0.8 0.6\nillum 5")


def rough_dielectric(folder):
    return with_sphere(folder, "rough dielectric", "Kd 0 0 0\nTf 0.9 0.95 1\nNi 1.5\nillum 7\nPr 0.5", max_depth=12)


def smooth_dielectric(folder):
    return with_sphere(folder, "smooth dielectric", "Kd 0 0 0\nTf 1 1 1\nNi 1.5\nillum 7", max_depth=12)


def textured(folder):
    """Floor and wall with a coarse picture, and a leaf with holes before the wall."""
    chance = np.random.default_rng(1)
    colours = chance.integers(30, 255, (24, 16, 3)).astype(np.uint8)
    Image.fromarray(colours).save(os.path.join(folder, "colours.png"))
    y, x = np.mgrid[0:32, 0:32]
    holes = np.where((x // 8 + y // 8) % 2 == 0, 255, 0) + np.where((x // 8 + y // 8) % 4 == 1, 90, 0)
    Image.fromarray(holes.astype(np.uint8)).save(os.path.join(folder, "holes.png"))
    scene = stage(folder, "textures and cut-outs")
    scene.material("picture", "map_Kd colours.png")
    scene.material("leaf", "Kd 0.3 0.6 0.2\nmap_d holes.png")
    scene.quad("picture", (-2, 0.01, 2), (4, 0, 0), (0, 0, -4))
    scene.quad("picture", (-1.5, 1, -2.9), (3, 0, 0), (0, 2, 0))
    scene.quad("leaf", (-1.2, 0.2, 0.5), (2.4, 0, -0.4), (0, 2, 0.2))
    return scene.view()


def environment(folder):
    """A sky with a gradient and a sun. Tamis takes a texel for a square, so that the first row's upper edge is the pole;
    Mitsuba puts the row's middle there. The map has so many rows that this does not show.
    """
    y, x = np.mgrid[0:1024, 0:2048]
    sky = np.stack([0.2 + 0.3 * x / 2048, 0.3 + 0.4 * y / 1024, np.full(x.shape, 0.8)], axis=-1).astype(np.float32)
    sky[192:288, 1376:1472] = [40.0, 35.0, 25.0]
    path = os.path.join(folder, "sky.exr")
    OpenEXR.File({}, {"RGB": np.ascontiguousarray(sky)}).write(path)
    scene = stage(folder, "environment", lamp=False)
    scene.sphere(scene.material("sphere", "Kd 0 0 0\nKs 0.9 0.9 0.9\nillum 5"), (0.9, 0.7, 0.8), 0.7)
    scene.sphere(scene.material("chalk", "Kd 0.7 0.7 0.7"), (-0.9, 0.8, 0.2), 0.8)
    return scene.view(environment=path)


def many_lights(folder):
    """Four hundred small lamps close over the floor. Mitsuba picks them all alike, so it gets more samples."""
    scene = stage(folder, "many small lights", lamp=False)
    scene.material("lamp", "Kd 0 0 0\nKe 30 25 20")
    chance = np.random.default_rng(2)
    for i in range(400):
        x, z = -2.9 + 0.29 * (i % 20), -2.9 + 0.29 * (i // 20)
        scene.quad("lamp", (x, chance.uniform(0.3, 2.5), z), (0.05, 0, 0), (0, chance.uniform(-0.04, 0.04), 0.05))
    return scene.view(max_depth=3, mitsuba_samples=16)


def thin_lens(folder):
    scene = stage(folder, "thin lens")
    for i, statements in enumerate(("Kd 0.8 0.2 0.1", "Kd 0.2 0.7 0.2", "Kd 0.2 0.3 0.9")):
        scene.sphere(scene.material(f"ball{i}", statements), (1.4 * (i - 1), 0.6, 1.6 - 1.6 * i), 0.6)
    return scene.view(lens_radius=0.25, focus_distance=6.5)


def with_two_balls(folder, name, lights):
    scene = stage(folder, name, lamp=False)
    scene.sphere(scene.material("chalk", "Kd 0.7 0.7 0.7"), (-0.9, 0.8, 0.2), 0.8)
    scene.sphere(scene.material("coated", "Kd 0.5 0.2 0.1\nKs 0.04 0.04 0.04\nPr 0.5"), (0.9, 0.7, 0.8), 0.7)
    return scene.view(lights=lights)


def unseen_lights(folder):
    """A point, a spot with a hard edge and one with a smooth one, a sun that is a point and one of six degrees."""
    point = {"type": "point", "position": [0.2, 2.6, 1.2], "intensity": [5, 4, 3]}
    hard = {"type": "spot", "position": [2, 3.5, 2.5], "look_at": [0.9, 0.7, 0.8], "intensity": [10, 25, 30]}
    hard |= {"cone_angle": 16, "cone_delta_angle": 0}
    smooth = {"type": "spot", "position": [-1.8, 3, 2], "look_at": [-1.8, 0, 2], "intensity": [30, 10, 10]}
    smooth |= {"cone_angle": 24, "cone_delta_angle": 18}
    sharp = {"type": "sun", "direction": [-1, -1.2, -0.4], "irradiance": [1, 0.9, 0.5], "angle": 0}
    wide = {"type": "sun", "direction": [0.4, -1.5, -1], "irradiance": [0.5, 0.7, 1], "angle": 6}
    return with_two_balls(folder, "points, spots and suns", [point, hard, smooth, sharp, wide])


def shapes_that_emit(folder):
    quad = {"type": "quad", "position": [1.5, 3.2, -1.5], "look_at": [0.9, 0.7, 0.8], "size": [1.6, 0.5]}
    quad |= {"radiance": [9, 8, 6]}
    disk = {"type": "disk", "position": [-2.9, 2.4, 0.5], "look_at": [0, 0.5, 0.5], "radius": 0.5, "radiance": [8, 2, 2]}
    sphere = {"type": "sphere", "position": [0.1, 1.9, -0.4], "radius": 0.3, "power": [10, 30, 40]}
    return with_two_balls(folder, "quad, disk and sphere", [quad, disk, sphere])


SCENES = [
    diffuse, coated, rough_conductor, smooth_conductor, rough_dielectric, smooth_dielectric, textured, environment,
    many_lights, thin_lens, unseen_lights, shapes_that_emit,
]


# --- Test -------------------------------------------------------------------------------------------------------------


def z_scores(tamis, mitsuba, spp):
    """Differences over their standard errors, for every pixel and channel."""
    # Mitsuba's floor is for the variance of a sample; pictures are means of spp.
    floor = 1e-4 / spp
    variances = [np.maximum(pictures.var(axis=0, ddof=1), floor) / len(pictures) for pictures in (tamis, mitsuba)]
    return (tamis.mean(axis=0) - mitsuba.mean(axis=0)) / np.sqrt(sum(variances))


def judge(tamis, mitsuba, spp):
    """Share of pixels that pass, root mean square of z, ratio of the means with its standard error, and the verdict."""
    z = z_scores(tamis, mitsuba, spp)
    pixels = z.shape[0] * z.shape[1]
    level = 1.0 - (1.0 - SIGNIFICANCE) ** (1.0 / pixels)
    p_values = np.vectorize(math.erfc)(np.abs(z) / math.sqrt(2.0))
    passed = (p_values > level).mean()
    (a, error_a), (b, error_b) = (mean_and_error(pictures.mean(axis=(1, 2, 3))) for pictures in (tamis, mitsuba))
    ratio, error = a / b, a / b * math.hypot(error_a / a, error_b / b)
    agrees = passed >= LEAST_SHARE and abs(ratio - 1.0) <= max(MEAN_TOLERANCE, 3.0 * error)
    return passed, math.sqrt((z**2).mean()), ratio, error, agrees


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--spp", type=int, default=64, help="of each seed")
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--first-seed", type=int, default=0, help="other seeds, another verdict")
    parser.add_argument("--only", help="name of a scene, with underscores")
    parser.add_argument("--tamis", default="target/debug/tamis")
    parser.add_argument("-o", "--output", default=".", help="folder of the scenes and pictures")
    return parser.parse_args()


def main():
    options, all_agree = parse_options(), True
    os.makedirs(options.output, exist_ok=True)
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    print("| scene | pixels that pass | rms z | Tamis ÷ Mitsuba | std. error | |\n|---|---|---|---|---|---|")
    for make in SCENES:
        if options.only not in (None, make.__name__):
            continue
        view = make(options.output)
        tamis = render_with_tamis(options.tamis, view, options.spp, seeds)
        mitsuba = render_with_mitsuba(view, options.spp * view.mitsuba_samples, seeds)
        passed, rms, ratio, error, agrees = judge(tamis, mitsuba, options.spp)
        name, verdict = os.path.splitext(os.path.basename(view.scene))[0], "agrees" if agrees else "differs"
        print(f"| {name} | {100 * passed:.2f} % | {rms:.3f} | {ratio:.4f} | {error:.4f} | {verdict} |", flush=True)
        picture = os.path.join(options.output, f"{make.__name__}.png")
        write_side_by_side(picture, tamis.mean(axis=0), mitsuba.mean(axis=0))
        all_agree &= agrees
    sys.exit(0 if all_agree else 1)


if __name__ == "__main__":
    main()
