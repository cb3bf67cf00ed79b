#!/usr/bin/env python3
"""Writes a mask for `tamis compare --mask` that leaves out bright pixels of a reference and those around them.

    pip install numpy openexr
    python scripts/mask_of_bright_pixels.py REFERENCE.exr -o MASK.exr [--above 5] [--radius 3]
    tamis compare REFERENCE.exr PICTURE.exr --mask MASK.exr

A pixel is bright where one of its channels R, G, B is above `--above`. Around it the square of `--radius` pixels on each
side is left out, too: a filter that shares weights between pixels smears a lamp's edge, whatever else it does.
"""

import argparse
import sys

from packages import need

need(__doc__, "numpy", "OpenEXR")

import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402


def read_picture(path):
    try:
        channels = OpenEXR.File(path, separate_channels=True).channels()
        return np.stack([channels[axis].pixels.astype(np.float32) for axis in "RGB"], axis=-1)
    except KeyError as missing:
        sys.exit(f"{path}: expected channels R, G, B, found no {missing.args[0]}")
    except Exception as error:
        sys.exit(f"{path}: cannot be read: {error}")


def grown(marked, radius):
    """What is marked, and the square of `radius` pixels on each side around it."""
    height, width = marked.shape
    padded = np.pad(marked, radius)
    steps = range(2 * radius + 1)
    return np.any([padded[y : y + height, x : x + width] for y in steps for x in steps], axis=0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference", metavar="REFERENCE.exr")
    parser.add_argument("-o", "--output", required=True, metavar="MASK.exr")
    parser.add_argument("--above", type=float, default=5.0, metavar="X", help="what is brighter is left out [default: 5]")
    parser.add_argument("--radius", type=int, default=3, metavar="N", help="pixels around it [default: 3]")
    options = parser.parse_args()
    if options.radius < 0:
        parser.error("--radius: expected 0 or more")
    left_out = grown((read_picture(options.reference) > options.above).any(axis=-1), options.radius)
    mask = np.ascontiguousarray(~left_out, dtype=np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {axis: mask for axis in "RGB"}).write(options.output)
    print(f"{options.output}: {np.count_nonzero(left_out)} of {left_out.size} pixels left out")


if __name__ == "__main__":
    main()
