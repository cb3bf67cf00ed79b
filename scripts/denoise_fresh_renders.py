#!/usr/bin/env python3
"""Renders a small scene with Mitsuba 3 and with Blender's Cycles, denoises it with `tamis`, and prints the errors.

    pip install mitsuba bpy     (tried with Mitsuba 3.9.1 and Blender 5.0.1; bpy wants one Python version)
    cargo build
    python scripts/denoise_fresh_renders.py -o DIR [--renderer mitsuba] [--tamis target/debug/tamis]

Where the two packages do not share an environment, run it in each with its `--renderer`: the rows are those of one table.

For each renderer DIR gets one stack with features as that renderer writes them (NAME.exr), the same samples as two
independent renders of half as many (NAME-a.exr, NAME-b.exr), and two references. The table has the noisy picture, what
`tamis denoise NAME.exr` makes of it without any flag, and what it makes of `--half-a NAME-a.exr --half-b NAME-b.exr`:
relative MSE against both references (`rmse_cross` of `tamis compare`), without the worst 0.1 % of pixels, and energy.
"""

import argparse
import json
import os
import subprocess
import sys

from packages import need

RENDERERS = ["mitsuba", "cycles"]
MODULES = {"mitsuba": "mitsuba", "cycles": "bpy"}
REFERENCES = [101, 102]  # seeds


# --- Mitsuba ---------------------------------------------------------------------------------------------------------


def render_with_mitsuba(jobs, size):
    """Renders a box with a metal and a glass ball; `jobs` are (file, samples, seed)."""
    import mitsuba

    mitsuba.set_variant("scalar_rgb")  # needs no LLVM
    from mitsuba import ScalarTransform4f as Transform

    scene = mitsuba.cornell_box()
    del scene["small-box"], scene["large-box"]
    scene["integrator"] = {
        "type": "aov",
        "aovs": "albedo:albedo,nn:sh_normal,pos:position,dd.y:depth",
        "img": {"type": "path", "max_depth": 12},
    }
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgba"}
    scene["sensor"]["film"] = film
    metal = {"type": "roughconductor", "material": "Cu", "alpha": 0.2}
    ball = {"type": "sphere", "to_world": Transform().translate([-0.4, -0.6, -0.3]).scale(0.4), "bsdf": metal}
    glass = {"type": "sphere", "to_world": Transform().translate([0.45, -0.7, 0.3]).scale(0.3)}
    scene |= {"ball": ball, "glass": glass | {"bsdf": {"type": "dielectric"}}}
    scene = mitsuba.load_dict(scene)
    for file, samples, seed in jobs:
        mitsuba.render(scene, spp=samples, seed=seed)
        scene.sensors()[0].film().write(file)


# --- Cycles ----------------------------------------------------------------------------------------------------------


def render_with_cycles(jobs, size):
    """Renders balls on a plane in front of a wall; `jobs` are (file, samples, seed)."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    build_in_blender(bpy, scene)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    layer = bpy.context.view_layer
    layer.cycles.denoising_store_passes = True
    layer.use_pass_position = layer.use_pass_normal = layer.use_pass_z = True
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # since Blender 5
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    for file, samples, seed in jobs:
        scene.cycles.samples, scene.cycles.seed = samples, seed
        scene.render.filepath = os.path.abspath(file)
        bpy.ops.render.render(write_still=True)


def build_in_blender(bpy, scene):
    def material(name, colour, metallic, roughness):
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        inputs = made.node_tree.nodes["Principled BSDF"].inputs
        inputs["Base Color"].default_value = (*colour, 1.0)
        inputs["Metallic"].default_value, inputs["Roughness"].default_value = metallic, roughness
        return made

    def shade(made):
        bpy.context.object.data.materials.append(made)

    bpy.ops.mesh.primitive_plane_add(size=20)
    shade(material("floor", (0.5, 0.45, 0.4), 0.0, 0.3))
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 4, 0), rotation=(1.5708, 0, 0))
    shade(material("wall", (0.3, 0.4, 0.6), 0.0, 0.8))
    balls = [(-1.6, (0.8, 0.2, 0.1), 0.0, 0.5), (0, (0.9, 0.8, 0.5), 1.0, 0.15), (1.6, (0.2, 0.6, 0.3), 0.0, 0.05)]
    for x, colour, metallic, roughness in balls:
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.7, location=(x, 0.5, 0.7), segments=64, ring_count=32)
        bpy.ops.object.shade_smooth()
        shade(material(f"ball{x}", colour, metallic, roughness))
    bpy.ops.object.light_add(type="AREA", location=(-2, -2, 4), rotation=(0.6, -0.4, 0))
    bpy.context.object.data.energy, bpy.context.object.data.size = 300, 0.5
    bpy.ops.object.camera_add(location=(0, -6, 2.2), rotation=(1.28, 0, 0))
    scene.camera = bpy.context.object
    scene.world = bpy.data.worlds.new("sky")
    scene.world.color = (0.05, 0.06, 0.08)


# --- Denoising and judging -------------------------------------------------------------------------------------------


def files_of(name, folder):
    endings = {"stack": ""} | {key: f"-{key}" for key in ("a", "b", "ref1", "ref2", "clean", "halves")}
    return {key: os.path.join(folder, f"{name}{ending}.exr") for key, ending in endings.items()}


def jobs_of(files, spp, reference_spp):
    halves = [(files["a"], spp // 2, 1), (files["b"], spp // 2, 2)]
    references = [(files[f"ref{i + 1}"], reference_spp, seed) for i, seed in enumerate(REFERENCES)]
    return [job for job in [(files["stack"], spp, 0), *halves, *references] if not os.path.exists(job[0])]


def run(command):
    print("$", " ".join(command), file=sys.stderr)
    outcome = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if outcome.returncode > 1:
        sys.exit(f"{command[0]} ended with {outcome.returncode}")
    return outcome.stdout


def judge(tamis, name, files):
    run([tamis, "denoise", files["stack"], "-o", files["clean"]])
    run([tamis, "denoise", "--half-a", files["a"], "--half-b", files["b"], "-o", files["halves"]])
    pictures = [files[key] for key in ("stack", "clean", "halves")]
    report = json.loads(run([tamis, "compare", files["ref1"], *pictures, "--ref2", files["ref2"], "--json"]))
    for label, image in zip(["noisy", "one stack", "two halves"], report["images"]):
        measures = [image[key] for key in ("rmse_cross", "rmse_cross_trimmed", "flip", "energy_ratio")]
        print(f"| {name} | {label} | " + " | ".join(f"{value:.4g}" for value in measures) + " |")


# --- Command line ----------------------------------------------------------------------------------------------------


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", required=True, help="folder of all files; what is there is not rendered again")
    parser.add_argument("--renderer", choices=RENDERERS, action="append", help="only this one")
    parser.add_argument("--tamis", default="target/debug/tamis", help="the program")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=32)
    parser.add_argument("--reference-spp", type=int, default=2048)
    parser.add_argument("--only-render", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args()


def main():
    options = parse_options()
    chosen = options.renderer or RENDERERS
    need(__doc__, *[MODULES[name] for name in chosen])
    os.makedirs(options.output, exist_ok=True)
    if options.only_render:  # in a process of its own: the two libraries do not get on
        [name] = chosen
        jobs = jobs_of(files_of(name, options.output), options.spp, options.reference_spp)
        {"mitsuba": render_with_mitsuba, "cycles": render_with_cycles}[name](jobs, options.size)
        return
    for name in chosen:
        again = [sys.executable, __file__, "--only-render", "--renderer", name, "-o", options.output]
        numbers = [f"--{key}={getattr(options, key.replace('-', '_'))}" for key in ("size", "spp", "reference-spp")]
        subprocess.run(again + numbers, check=True, stdout=sys.stderr)
    print("| renderer | picture | cross rMSE | trimmed | FLIP | energy |\n|---|---|---|---|---|---|")
    for name in chosen:
        judge(options.tamis, name, files_of(name, options.output))


if __name__ == "__main__":
    main()
