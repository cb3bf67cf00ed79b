#!/usr/bin/env python3
"""Writes an OBJ file of many triangles, renders it, and tells memory per triangle and the speed of loading.

    python scripts/measure_big_scene.py               (ten million triangles: a file of 400 MB, some minutes)

The mesh is a sheet of hills, vertices shared, without normals or texture coordinates. Printed are the largest memory that
the process held over the triangles, and the file's size over the time that reading it took, both as `tamis render --json`
tells them. Plain Python, no packages.
"""

import argparse
import math
import os

import measuring

# Rows that are made into text at a time.
AT_ONCE = 64


def write_sheet(path, side):
    """A sheet of side × side quads, each of two triangles, over [0, 1]²."""
    waves = [[math.sin(f * math.tau * i / side) for i in range(side + 1)] for f in (3, 17, 61)]
    with open(path, "w", encoding="ascii") as file:
        for z in range(side + 1):
            heights = (sum(w[x] * w[z] / (20 + 60 * k) for k, w in enumerate(waves)) for x in range(side + 1))
            file.write("".join(f"v {x / side:.6f} {y:.6f} {z / side:.6f}\n" for x, y in enumerate(heights)))
        for z in range(side):
            row = z * (side + 1) + 1
            quads = ((row + x, row + x + 1, row + x + side + 2, row + x + side + 1) for x in range(side))
            file.write("".join(f"f {a} {d} {c}\nf {a} {c} {b}\n" for a, b, c, d in quads))


def measure(options, folder):
    side = round(math.sqrt(options.triangles / 2))
    scene = os.path.join(folder, "sheet.obj")
    write_sheet(scene, side)
    command = [options.tamis, "render", scene, "--eye=0.5,0.8,1.6", "--look-at=0.5,0,0.4", "--size=320x240", "--spp=1"]
    command += ["--uniform", "--no-denoise", "--aov=none", "-o", os.path.join(folder, "sheet.exr")]
    report = measuring.report_of(command)
    triangles, size, seconds = 2 * side * side, os.path.getsize(scene), report["seconds"]
    print(f"{triangles} triangles, {size / 1e6:.0f} MB of OBJ")
    print(f"memory: {report['peak_bytes'] / triangles:.0f} bytes a triangle, {report['peak_bytes'] / 1e9:.2f} GB in all")
    print(f"reading: {seconds['load']:.2f} s, {size / 1e6 / seconds['load']:.0f} MB/s")
    print(f"building the tree: {seconds['build']:.2f} s, {triangles / 1e6 / seconds['build']:.2f} million triangles/s")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, default=10_000_000)
    measuring.run(parser, measure)


if __name__ == "__main__":
    main()
