#!/usr/bin/env python3
"""Makes folders for `tamis experiment guide`: a noisy stack, references, and what Open Image Denoise makes of the stack.

    python scripts/guide_stacks.py SCENE… FOLDER… -o DIR --spp 32,128
    tamis experiment guide DIR/* -o OUT

A SCENE (.obj, .toml) is rendered with `--spp` samples a pixel, uniformly, and twice as a reference; each number of samples
gives a folder DIR/SCENE-SPP. A FOLDER that holds a stack already (b0.exr, b1.exr …, ref1.exr, perhaps ref2.exr) gets the
pictures of OIDN that are missing: oidn.exr, oidn-clean.exr (features denoised first), oidn-colour.exr (from colour alone).
Needs what denoise_with_oidn.py needs (pip install pyoidn numpy openexr). The same seed gives the same stacks.
"""

import argparse
import os

from packages import need

need(__doc__, "numpy", "OpenEXR", "pyoidn")

import pyoidn  # noqa: E402
from denoise_with_oidn import denoise, read_buckets, read_stack, run_filter, sound, write_picture  # noqa: E402
from measuring import call  # noqa: E402

# Seed of the first reference; the second has the next.
REFERENCE_SEED = 90001


def render(options, scene, output, spp, seed):
    """Renders what is not there; --resume leaves a finished render alone and refuses another scene's, or another size."""
    command = [options.tamis, "render", scene, "--size", options.size, "--spp", str(spp), "--seed", str(seed)]
    call([*command, "--uniform", "--no-denoise", "--resume", "--quiet", "-o", output])


def render_folders(options, scene):
    """The folders of a scene, one for each number of samples."""
    name = os.path.splitext(os.path.basename(scene))[0]
    for spp in options.spp.split(","):
        folder = os.path.join(options.output, f"{name}-{spp}")
        os.makedirs(folder, exist_ok=True)
        render(options, scene, os.path.join(folder, "b0.exr"), spp, options.seed + int(spp))
        for number in (1, 2):
            whole = os.path.join(options.output, f".{name}-{options.size}-{options.reference_spp}spp-ref{number}.exr")
            render(options, scene, whole, options.reference_spp, REFERENCE_SEED + number - 1)
            link = os.path.join(folder, f"ref{number}.exr")
            if os.path.islink(link):
                os.remove(link)
            if not os.path.exists(link):
                os.symlink(os.path.abspath(whole), link)
        yield folder, True


def add_oidn(device, folder, is_own):
    """Adds OIDN's pictures; stacks of ours have their emission apart."""
    stack = read_stack(os.path.join(folder, "b0.exr"), False) if is_own else read_buckets(folder)
    colour, albedo, normal, emission = stack
    inputs = sound(colour, 0.0), sound(albedo, 0.0), sound(normal, -1.0)
    pictures = {
        "oidn": lambda: denoise(device, *inputs, False)[0],
        "oidn-clean": lambda: denoise(device, *inputs, True)[0],
        "oidn-colour": lambda: run_filter(device, {pyoidn.OIDN_IMAGE_COLOR: inputs[0]}, hdr=True)[0],
    }
    for name, make in pictures.items():
        path = os.path.join(folder, f"{name}.exr")
        if not os.path.exists(path):
            write_picture(path, make() + emission)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sources", nargs="+", metavar="SCENE|FOLDER")
    parser.add_argument("-o", "--output", default=".", metavar="DIR", help="where folders of scenes go")
    parser.add_argument("--spp", default="32,128", metavar="N,N…")
    parser.add_argument("--reference-spp", type=int, default=1024, metavar="N")
    parser.add_argument("--size", default="96x96", metavar="WxH")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--tamis", default="target/debug/tamis", metavar="FILE")
    options = parser.parse_args()
    with pyoidn.Device() as device:
        device.commit()
        for source in options.sources:
            folders = [(source, False)] if os.path.isdir(source) else render_folders(options, source)
            for folder, is_own in folders:
                add_oidn(device, folder, is_own)
                print(folder)


if __name__ == "__main__":
    main()
