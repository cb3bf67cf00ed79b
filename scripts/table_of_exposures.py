#!/usr/bin/env python3
"""Prints how the error of `tamis denoise` depends on the units of light.

    pip install numpy openexr
    python scripts/table_of_exposures.py STACK=REF,REF2 … [--factors 0.0625,1,16] [--flags FLAGS]

Each STACK, an EXR file that Tamis wrote with its inputs, is made so many times as bright, denoised, and made as dark again;
the table has its `rmse_cross` / `rmse_cross_trimmed` over those of the stack as it is, and last their geometric means.
"""

import argparse
import os

from packages import need

need(__doc__, "numpy", "OpenEXR")

import numpy  # noqa: E402
import OpenEXR  # noqa: E402
from measuring import call, report_of, run  # noqa: E402

# First parts of the names of layers that hold light.
LIGHT = {"RGB", "R", "G", "B", "noisy", "emission", "indirect", "gathered"}


def scale(source, factor, output):
    file = OpenEXR.File(source)
    for part in file.parts:
        for name, channel in part.channels.items():
            if name.split(".")[0] in LIGHT:
                channel.pixels = channel.pixels * numpy.float32(factor)
    file.write(output)


def errors(options, folder, stack, references, factor):
    scaled, clean, back = (os.path.join(folder, f"{name}.exr") for name in ("scaled", "clean", "back"))
    scale(stack, factor, scaled)
    denoise = [options.tamis, "denoise", scaled, "-o", clean, "--aov", "none", "--quiet", *options.flags]
    call(denoise)
    scale(clean, 1 / factor, back)
    image = report_of([options.tamis, "compare", references[0], back, "--ref2", references[1]])["images"][0]
    return numpy.array([image["rmse_cross"], image["rmse_cross_trimmed"]])


def stack_and_references(argument):
    stack, _, references = argument.partition("=")
    if references.count(",") != 1:
        raise argparse.ArgumentTypeError(f"{argument}: expected STACK=REF,REF2, with two references")
    return stack, references.split(",")


def measure(options, folder):
    factors = [float(factor) for factor in options.factors.split(",")]
    print("| stack |", " | ".join(f"× {factor:g}" for factor in factors), "|\n|---" + "|---" * len(factors) + "|")
    show = lambda ratios: " | ".join(" / ".join(f"{value:.3f}" for value in pair) for pair in ratios)
    logarithms = []
    for argument in options.stacks:
        stack, references = argument
        plain, *others = (errors(options, folder, stack, references, factor) for factor in [1, *factors])
        ratios = [other / plain for other in others]
        logarithms.append(numpy.log(ratios))
        print("|", os.path.basename(stack), "|", show(ratios), "|", flush=True)
    print("| geometric mean |", show(numpy.exp(numpy.mean(logarithms, axis=0))), "|")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stacks", nargs="+", type=stack_and_references, metavar="STACK=REF,REF2")
    parser.add_argument("--factors", default="0.0625,0.25,4,16", metavar="F,F…")
    parser.add_argument("--flags", default="", type=str.split, help="more flags for tamis denoise, in one argument")
    run(parser, measure)
