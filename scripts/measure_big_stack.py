#!/usr/bin/env python3
"""Repeats a small stack over a large picture, denoises that, and tells memory and time per pixel.

    python scripts/measure_big_stack.py FILE.exr                                (8192×4096: up to half an hour)
    python scripts/measure_big_stack.py FILE.exr --size 2048x2048 --max-memory 2G

FILE is any stack that `tamis denoise FILE` takes. Its seams are no pictures, but they are work. Needs numpy and OpenEXR.
"""

import argparse
import os

from packages import need

need(__doc__, "numpy", "OpenEXR")

import measuring  # noqa: E402
import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402


def repeat(source, path, width, height):
    """The channels of `source` repeated over width × height pixels; half floats stay half floats."""

    def repeated(plane):
        rows, columns = (-(-to // of) for to, of in zip((height, width), plane.shape))
        return np.ascontiguousarray(np.tile(plane, (rows, columns))[:height, :width])

    channels = OpenEXR.File(source, separate_channels=True).channels()
    header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {name: repeated(channel.pixels) for name, channel in channels.items()}).write(path)


def measure(options, folder):
    width, height = (int(side) for side in options.size.split("x"))
    stack = os.path.join(folder, "noisy.exr")
    repeat(options.stack, stack, width, height)
    command = [options.tamis, "denoise", stack, "-o", os.path.join(folder, "clean.exr")]
    command += ["--max-memory", options.max_memory] if options.max_memory else []
    report = measuring.report_of(command)
    pixels, seconds = width * height, report["seconds"]
    work = sum(report["stages"].values())
    print(f"{width}×{height}: a file of {os.path.getsize(stack) / 1e9:.2f} GB")
    print(f"memory: {report['peak_bytes'] / pixels:.0f} bytes a pixel, {report['peak_bytes'] / 2**30:.1f} GiB in all")
    print(f"read {seconds['load']:.0f} s, work {work:.0f} s ({1e6 * work / pixels:.1f} s/Mpix), write {seconds['write']:.0f} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stack", metavar="FILE")
    parser.add_argument("--size", default="8192x4096")
    parser.add_argument("--max-memory")
    measuring.run(parser, measure)


if __name__ == "__main__":
    main()
