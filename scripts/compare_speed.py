#!/usr/bin/env python3
"""Speed of Tamis beside Embree 4 (rays) and Mitsuba 3 (samples), measured in turn within one run.

    pip install embreex mitsuba numpy openexr pillow  (tried with embreex 4.4, mitsuba 3.9, numpy 1.26 and 2)
    python scripts/compare_speed.py [SCENE.obj …]     (scenes/study.obj and scenes/halves.obj by default; five minutes)

Rays: from anywhere in the scene's box to anywhere, as benches/rays.rs draws them; ours by that bench (`cargo bench
--profile dev --bench rays`, its random numbers repeated here), Embree's by embreex, which casts single rays one after the
other as the bench does; both on one thread. Both include what the caller gets: Tamis the surface at the hit, Embree the
number of the triangle; embreex copies each ray into and out of Embree's own form besides. Trees are built with all threads.

Samples: a path tracer of the same depth on scenes/study.obj, all threads, Mitsuba in llvm_ad_rgb with its kernel compiled
before. Tamis also records features, and takes light samples by a tree.

Each figure is the best of `--rounds` alternations. Speed depends on the machine: what counts are the ratios.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time

from packages import need

need(__doc__, "numpy", "OpenEXR", "PIL", "mitsuba", "embreex")

import numpy as np  # noqa: E402
from both_renderers.mitsuba_scene import mitsuba_scene  # noqa: E402
from both_renderers.mitsuba_variant import mi  # noqa: E402
from both_renderers.obj import read_obj  # noqa: E402
from both_renderers.view import View  # noqa: E402
from embreex import mesh_construction, rtcore_scene  # noqa: E402

HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
RAYS = 10_000
REPEATS = 20
STUDY = {"eye": [0.75, 1.32, 1.05], "look_at": [-0.02, 0.86, -1.0], "fov": 40.0, "size": [320, 240], "max_depth": 8}
SPP = 32


# --- Rays -------------------------------------------------------------------------------------------------------------


def random_units(count):
    """The bench's SplitMix64 numbers in [0, 1)."""
    step = np.uint64(0x9E3779B97F4A7C15)
    with np.errstate(over="ignore"):
        z = np.uint64(2) + step * np.arange(1, count + 1, dtype=np.uint64)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z ^= z >> np.uint64(31)
    return (z >> np.uint64(40)).astype(np.float32) / np.float32(1 << 24)


def bench_rays(low, high):
    """Origins and directions as the bench draws them: points of a cube are refused that give no direction."""
    points = 2.0 * random_units(16 * RAYS * 3).reshape(-1, 3) - 1.0
    squared = (points**2).sum(axis=1)
    usable = (squared >= 0.01) & (squared < 1.0)
    origins, directions, at = [], [], 0
    for _ in range(RAYS):
        origins.append(points[at])
        at += 1
        while not usable[at]:
            at += 1
        directions.append(points[at] / np.sqrt(squared[at]))
        at += 1
    origins = (low + high) / 2.0 + (high - low) / 2.0 * np.array(origins)
    return origins.astype(np.float32), np.array(directions, dtype=np.float32)


def embree(path):
    """Seconds to build, and millions of rays a second: closest hit, occlusion."""
    obj = read_obj(path)
    corners = [[c[0] for c in t] for part in obj.parts for t in part.triangles]
    triangles = obj.positions.astype(np.float32)[np.array(corners)]
    origins, directions = bench_rays(triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1)))
    scene = rtcore_scene.EmbreeScene()
    mesh_construction.TriangleMesh(scene, triangles)
    start = time.perf_counter()
    scene.run(origins[:1], directions[:1])
    build = time.perf_counter() - start
    rates = []
    for query in ("INTERSECT", "OCCLUDED"):
        best = min(timed(lambda: scene.run(origins, directions, query=query)) for _ in range(REPEATS))
        rates.append(RAYS / best / 1e6)
    return [build, *rates]


def timed(work):
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def tamis_rays(path):
    """The same of Tamis, as the bench tells them."""
    command = ["cargo", "bench", "--quiet", "--profile", "dev", "--bench", "rays", "--", "--noplot"]
    environment = os.environ | {"TAMIS_BENCH_SCENE": os.path.abspath(path)}
    done = subprocess.run(command, cwd=HERE, env=environment, check=True, capture_output=True, text=True)
    build = float(re.search(r"tree built in (\S+) s", done.stderr)[1])
    rates = []
    for name in ("closest hit", "occlusion"):
        with open(os.path.join(HERE, "target", "criterion", "rays_given", name, "new", "sample.json")) as file:
            sample = json.load(file)
        # Nanoseconds of so many passes over all rays.
        best = min(time / passes for time, passes in zip(sample["times"], sample["iters"]))
        rates.append(RAYS / best * 1e3)
    return [build, *rates]


# --- Samples ----------------------------------------------------------------------------------------------------------


def tamis_samples(tamis, view):
    """Millions of samples a second."""
    with tempfile.TemporaryDirectory() as folder:
        command = [tamis, "render", view.scene, "--uniform", "--no-denoise", "--aov=none", "--json", "--quiet"]
        command += [f"--{k}={','.join(map(str, v))}" for k, v in (("eye", view.eye), ("look-at", view.look_at))]
        command += [f"--fov={view.fov}", f"--size={view.size[0]}x{view.size[1]}", f"--max-depth={view.max_depth}"]
        command += [f"--spp={SPP}", "-o", os.path.join(folder, "picture.exr")]
        report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return report["samples"] / report["seconds"]["trace"] / 1e6


def mitsuba_samples(scene, view):
    """The same."""
    seconds = timed(lambda: np.array(mi.render(scene, spp=SPP)))
    return view.size[0] * view.size[1] * SPP / seconds / 1e6


# --- Table ------------------------------------------------------------------------------------------------------------


def row(what, ours, theirs, more_is_better=True):
    """A row of the table; the ratio is above 1 where Tamis is faster."""
    ratio = ours / theirs if more_is_better else theirs / ours
    print(f"| {what} | {ours:.3g} | {theirs:.3g} | {ratio:.2f} |", flush=True)


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    own = [os.path.join(HERE, "scenes", f"{name}.obj") for name in ("study", "halves")]
    parser.add_argument("scenes", nargs="*", default=own)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--tamis", default=os.path.join(HERE, "target/debug/tamis"))
    return parser.parse_args()


def main():
    options = parse_options()
    print("| | Tamis | Embree | Tamis's speed ÷ Embree's |\n|---|---|---|---|")
    for path in options.scenes:
        rounds = [(tamis_rays(path), embree(path)) for _ in range(options.rounds)]
        name = os.path.splitext(os.path.basename(path))[0]
        ours, theirs = (np.array([both[i] for both in rounds]) for i in (0, 1))
        row(f"{name}: tree, seconds", ours[:, 0].min(), theirs[:, 0].min(), more_is_better=False)
        row(f"{name}: closest hit, Mrays/s", ours[:, 1].max(), theirs[:, 1].max())
        row(f"{name}: occlusion, Mrays/s", ours[:, 2].max(), theirs[:, 2].max())
    print("\n| | Tamis | Mitsuba | Tamis's speed ÷ Mitsuba's |\n|---|---|---|---|")
    view = View(os.path.join(HERE, "scenes", "study.obj"), **STUDY)
    with tempfile.TemporaryDirectory() as folder:
        scene = mitsuba_scene(view, folder)
        mitsuba_samples(scene, view)
        rounds = [(tamis_samples(options.tamis, view), mitsuba_samples(scene, view)) for _ in range(options.rounds)]
    ours, theirs = (max(both[i] for both in rounds) for i in (0, 1))
    row("study: path tracing, Msamples/s", ours, theirs)


if __name__ == "__main__":
    sys.exit(main())
