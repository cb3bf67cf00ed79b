#!/usr/bin/env python3
"""Renders glTF files with `tamis` and with Blender's Cycles under an even sky, and prints how far the pictures are apart.

    pip install bpy numpy openexr      (tried with Blender 5.0.1; bpy wants one Python version)
    cargo build
    python scripts/compare_gltf_with_cycles.py FILE.glb... [--spp 128] [--size 200] [--folder DIR] [--tamis target/debug/tamis]

The camera looks along the box of what is there, from the front, the right and above. For each file: means of the pixels
that show something, Tamis's over Cycles', for red, green and blue; and the share of pixels that differ by more than 0.1
once that is taken off. Cycles' principled material is not glTF's to the letter, and Tamis's coat is neither: a few per cent
between the means are no mistake, pixels that differ are (textures, their places, normals, metal).
"""

import argparse
import json
import math
import os
import subprocess

import measuring

FOV = 40.0


def camera_of(bounds):
    """Eye and target, from the box round the scene."""
    low, high = bounds
    centre = [(a + b) / 2 for a, b in zip(low, high)]
    radius = math.dist(low, high) / 2
    distance = radius / math.sin(math.radians(FOV / 2))
    eye = [c + d * distance for c, d in zip(centre, (0.35, 0.3, 0.887))]
    return eye, centre


def render_with_cycles(file, picture, eye, target, size, spp):
    import bpy
    from mathutils import Vector

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(file))
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    sky = scene.world.node_tree.nodes["Background"].inputs
    sky[0].default_value, sky[1].default_value = (1, 1, 1, 1), 1
    # glTF's y is Blender's z.
    eye, target = (Vector((x, -z, y)) for x, y, z in (eye, target))
    camera = bpy.data.cameras.new("camera")
    seen = bpy.data.objects.new("camera", camera)
    scene.collection.objects.link(seen)
    seen.location, seen.rotation_euler = eye, (target - eye).to_track_quat("-Z", "Y").to_euler()
    camera.sensor_fit, camera.sensor_height = "VERTICAL", 24
    # As Tamis, whatever the units.
    distance = (target - eye).length
    camera.clip_start, camera.clip_end = distance / 1000, distance * 1000
    camera.lens = 12 / math.tan(math.radians(FOV / 2))
    scene.camera = seen
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = spp, False, False
    scene.cycles.max_bounces = 32
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath(picture)
    bpy.ops.render.render(write_still=True)


def pixels_of(picture):
    import numpy
    import OpenEXR

    with OpenEXR.File(picture) as file:
        planes = [c.pixels for c in file.parts[0].channels.values() if c.pixels.ndim == 3]
    return planes[0][..., :3].astype(numpy.float64)


def measure(options, folder):
    print("| file | red | green | blue | pixels that differ |\n|---|---|---|---|---|")
    for file in options.files:
        info = subprocess.run([options.tamis, "info", file, "--json"], check=True, stdout=subprocess.PIPE)
        bounds = json.loads(info.stdout)[0]["bounds"]
        eye, target = camera_of([bounds["min"], bounds["max"]] if isinstance(bounds, dict) else bounds)
        stem = os.path.splitext(os.path.basename(file))[0]
        ours, theirs = (os.path.join(folder, f"{stem}-{name}.exr") for name in ("tamis", "cycles"))
        command = [options.tamis, "render", file, "--size", f"{options.size}x{options.size}", "--spp", str(options.spp)]
        command += ["--uniform", "--no-denoise", "--aov", "none", "--env", "1,1,1", "--fov", str(FOV), "-o", ours, "-q"]
        command += ["--eye", ",".join(map(str, eye)), "--look-at", ",".join(map(str, target))]
        subprocess.run(command, check=True)
        render_with_cycles(file, theirs, eye, target, options.size, options.spp)
        ours, theirs = pixels_of(ours), pixels_of(theirs)
        shown = (abs(ours - 1).max(-1) > 0.02) | (abs(theirs - 1).max(-1) > 0.02)
        ratio = ours[shown].mean(0) / theirs[shown].mean(0)
        differ = (abs(ours - theirs * ratio).max(-1) > 0.1)[shown].mean()
        print(f"| {stem} | " + " | ".join(f"{r:.3f}" for r in ratio) + f" | {100 * differ:.2f} % |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", help="glTF files")
    parser.add_argument("--spp", type=int, default=128)
    parser.add_argument("--size", type=int, default=200)
    measuring.run(parser, measure)
