"""Pictures by both renderers."""

import json
import os
import subprocess
import tempfile

import numpy as np
import OpenEXR

from .mitsuba_scene import mitsuba_scene
from .mitsuba_variant import mi


def render_with_mitsuba(view, spp, seeds):
    """One picture per seed: seeds × height × width × 3."""
    with tempfile.TemporaryDirectory() as folder:
        scene = mitsuba_scene(view, folder)
        pictures = [np.array(mi.render(scene, spp=spp, seed=seed)) for seed in seeds]
    return np.stack(pictures).astype(np.float64)


def render_with_tamis(tamis, view, spp, seeds):
    """One picture per seed: seeds × height × width × 3. `tamis` is the program."""
    with tempfile.TemporaryDirectory() as folder:
        path, scene = os.path.join(folder, "picture.exr"), view.scene
        if view.lights:
            scene = os.path.join(folder, "scene.toml")
            write_scene_toml(scene, view)
        return np.stack([tamis_picture(tamis, scene, view, spp, seed, path) for seed in seeds])


def write_scene_toml(path, view):
    """The geometry with the lights. Strings, numbers and lists are written alike in JSON and TOML."""
    tables = [("geometry", {"file": os.path.abspath(view.scene)}), *(("light", light) for light in view.lights)]
    with open(path, "w") as file:
        for name, table in tables:
            file.write(f"[[{name}]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items()))


def tamis_picture(tamis, scene, view, spp, seed, path):
    def joined(values):
        return ",".join(str(v) for v in values)

    command = [tamis, "render", scene, "--uniform", "--no-denoise", "--quiet", "--aov", "none"]
    command += [f"--eye={joined(view.eye)}", f"--look-at={joined(view.look_at)}", f"--up={joined(view.up)}"]
    command += [f"--fov={view.fov}", f"--size={view.size[0]}x{view.size[1]}", f"--spp={spp}"]
    command += [f"--lens-radius={view.lens_radius}", f"--focus-distance={view.focus_distance}"]
    command += [f"--max-depth={view.max_depth}", f"--seed={seed}", "-o", path]
    command += [f"--env={view.environment}"] if view.environment else []
    subprocess.run(command, check=True)
    channels = OpenEXR.File(path, separate_channels=True).channels()
    return np.stack([channels[c].pixels for c in "RGB"], axis=-1).astype(np.float64)
