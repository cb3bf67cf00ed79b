#!/usr/bin/env python3
"""Renders one OBJ scene with Tamis and with Mitsuba 3, and tells whether the pictures differ by more than noise.

    pip install mitsuba numpy openexr pillow          (tried with mitsuba 3.9, numpy 2, openexr 3.5, pillow 13)
    python scripts/compare_with_mitsuba.py SCENE.obj --eye 0,1,5 --look-at 0,1,0 --fov 30 -o DIR

A place that begins with a minus needs an equals sign: --eye=-0.01,0.995,4.835.

For Mitsuba, geometry, materials and camera are read and built by the modules of both_renderers, from the OBJ and MTL files and from
what Tamis documents; no code is shared with Tamis. Both render `--seeds` pictures of `--spp` samples with as many
independent seeds, from whose spread the standard errors follow. Printed are the means per channel with their ratio, and
how far the means over blocks of 16 × 16 pixels lie apart in units of their standard error. DIR gets both pictures side by
side with their difference. The exit status is 1 when a ratio is off by more than `--tolerance` and by more than 3
standard errors.

Known to differ: Tamis sees the geometric normal where a viewer is below the shading horizon, Mitsuba turns the shading
normal round, which shows at silhouettes of coarse meshes; and Tamis's coats look albedos up in a table that is right to
0.002. Of textures, those of diffuse colour and of opacity are supported.

Errors come from few seeds, and caustics' noise has long tails: look at a deviating block again with other seeds
(`--first-seed`) before believing it.
"""

import argparse
import math
import os
import sys

from packages import need

need(__doc__, "numpy", "OpenEXR", "PIL", "mitsuba")

import numpy as np  # noqa: E402
from both_renderers.comparison import mean_and_error, write_side_by_side  # noqa: E402
from both_renderers.renders import render_with_mitsuba, render_with_tamis  # noqa: E402
from both_renderers.trapezoid import trapezoid  # noqa: E402
from both_renderers.view import View  # noqa: E402

BLOCK = 16


# --- Statistics ------------------------------------------------------------------------------------------------------


def block_means(pictures):
    """Means over blocks of 16 × 16 pixels; what is left at the right and the bottom is not looked at."""
    seeds, height, width, _ = pictures.shape
    rows, columns = height // BLOCK, width // BLOCK
    cut = pictures[:, : rows * BLOCK, : columns * BLOCK]
    return cut.reshape(seeds, rows, BLOCK, columns, BLOCK, 3).mean(axis=(2, 4))


def student_tail(limit, freedom):
    """Share of Student's t that lies beyond ± limit: errors estimated from few seeds have longer tails than noise."""
    t = np.linspace(-limit, limit, 20001)
    norm = math.exp(math.lgamma((freedom + 1) / 2) - math.lgamma(freedom / 2)) / math.sqrt(freedom * math.pi)
    return 1.0 - norm * trapezoid((1.0 + t * t / freedom) ** (-(freedom + 1) / 2), t)


def report_means(tamis, mitsuba, tolerance):
    """Prints the means; whether they agree."""
    agrees = True
    print("channel       Tamis  std.err     Mitsuba  std.err       ratio  std.err")
    for channel, name in enumerate("RGB"):
        (a, ea), (b, eb) = (mean_and_error(p[..., channel].mean(axis=(1, 2))) for p in (tamis, mitsuba))
        ratio, error = a / b, a / b * math.hypot(ea / a, eb / b)
        print(f"{name:7} {a:11.6f} {ea:8.6f} {b:11.6f} {eb:8.6f} {ratio:11.5f} {error:8.5f}")
        agrees &= abs(ratio - 1.0) <= max(tolerance, 3.0 * error)
    return agrees


def report_blocks(tamis, mitsuba):
    (a, ea), (b, eb) = mean_and_error(block_means(tamis)), mean_and_error(block_means(mitsuba))
    error = np.hypot(ea, eb)
    deviation = np.divide(a - b, error, out=np.where(a == b, 0.0, np.inf), where=error > 0.0)
    row, column, channel = np.unravel_index(np.abs(deviation).argmax(), deviation.shape)
    beyond, tail = (np.abs(deviation) > 3.0).mean(), student_tail(3.0, 2 * (len(tamis) - 1))
    print(f"\nblocks of {BLOCK}x{BLOCK} pixels, each channel: {deviation.size}")
    print(
        f"largest deviation: {deviation[row, column, channel]:+.2f} standard errors ({'RGB'[channel]} of block "
        f"{column},{row}: {a[row, column, channel]:.6f} and {b[row, column, channel]:.6f})"
    )
    print(f"root mean square deviation: {np.sqrt((deviation**2).mean()):.2f} standard errors")
    print(f"beyond 3 standard errors: {100 * beyond:.2f} % (by chance {100 * tail:.2f} %)")


# --- Command line ----------------------------------------------------------------------------------------------------


def parse_options():
    def triple(text):
        return [float(v) for v in text.split(",")]

    def size(text):
        return [int(v) for v in text.split("x")]

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--eye", type=triple, required=True)
    parser.add_argument("--look-at", type=triple, required=True)
    parser.add_argument("--up", type=triple, default=[0.0, 1.0, 0.0])
    parser.add_argument("--fov", type=float, default=45.0, help="vertical, in degrees")
    parser.add_argument("--size", type=size, default=[128, 128])
    parser.add_argument("--spp", type=int, default=32, help="of each seed")
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--first-seed", type=int, default=0, help="other seeds, another verdict")
    parser.add_argument("--max-depth", type=int, default=8, help="scattering events, as Tamis counts them")
    parser.add_argument("--tolerance", type=float, default=0.01)
    parser.add_argument("--tamis", default="target/debug/tamis")
    parser.add_argument("-o", "--output", default=".", help="folder of the pictures")
    return parser.parse_args()


def main():
    options = parse_options()
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    view = View(
        options.scene, options.eye, options.look_at, options.up, options.fov, options.size, max_depth=options.max_depth
    )
    tamis = render_with_tamis(options.tamis, view, options.spp, seeds)
    mitsuba = render_with_mitsuba(view, options.spp, seeds)
    agrees = report_means(tamis, mitsuba, options.tolerance)
    report_blocks(tamis, mitsuba)
    os.makedirs(options.output, exist_ok=True)
    name = os.path.splitext(os.path.basename(options.scene))[0]
    write_side_by_side(os.path.join(options.output, f"{name}.png"), tamis.mean(axis=0), mitsuba.mean(axis=0))
    sys.exit(0 if agrees else 1)


if __name__ == "__main__":
    main()
