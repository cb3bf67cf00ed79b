#!/usr/bin/env python3
"""Denoises stacks with Intel Open Image Denoise, so that `tamis compare` can set its pictures beside Tamis's.

    pip install pyoidn numpy openexr          (tried with pyoidn 2.5.1, which brings OIDN 2.5.1, numpy 2, openexr 3.5)
    python scripts/denoise_with_oidn.py STACK… -o DIR
    tamis compare REF1.exr --ref2 REF2.exr DIR/NAME-oidn.exr DIR/NAME-oidn-clean.exr

A STACK is an EXR file that Tamis wrote with its inputs, or a folder of independent renders b0.exr, b1.exr …, each with
colour, albedo and normal under names that `tamis denoise --buckets` knows; their means are taken. OIDN's filter for
ray-traced pictures gets HDR colour, albedo and normal at its high quality, and makes two pictures in DIR:

    NAME-oidn.exr           with albedo and normal as they are
    NAME-oidn-clean.exr     with albedo and normal denoised by OIDN first (cleanAux)

Tamis keeps lamps and background that are seen directly in a layer of their own. As Tamis does, only what is scattered is
denoised, and that layer's mean is added afterwards; `--with-emission` lets OIDN denoise both together. Stacks of other
renderers have no such layer, and are denoised whole.

Values that are not finite or negative count as black, for OIDN would spread them. Seconds printed are those of filters
alone: on as many threads as OIDN finds, without loading weights or files.
"""

import argparse
import os
import sys
import time

from packages import need

need(__doc__, "numpy", "OpenEXR", "pyoidn")

import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402
import pyoidn  # noqa: E402

# Layers that hold a feature, the first that is there; case, separators and what stands in front do not matter.
ALBEDO = ["denoisingalbedo", "albedo", "diffusealbedo"]
NORMAL = ["denoisingnormal", "shnormal", "ns", "normal", "n"]
COLOUR = ["combined", "noisyimage", "noisy", "beauty", "rgba"]


# --- Stacks ----------------------------------------------------------------------------------------------------------


def read_channels(path):
    """All channels of an EXR file as float32 planes, by full name."""
    try:
        channels = OpenEXR.File(path, separate_channels=True).channels()
    except Exception as error:
        sys.exit(f"{path}: cannot be read: {error}")
    return {name: channel.pixels.astype(np.float32) for name, channel in channels.items()}


def layer(channels, name):
    """The layer called exactly `name` as height × width × 3; None when it is not there."""
    prefix = f"{name}." if name else ""
    for axes in ("RGB", "XYZ"):
        planes = [channels.get(prefix + axis) for axis in axes]
        if all(plane is not None for plane in planes):
            return np.ascontiguousarray(np.stack(planes, axis=-1))
    return None


def layer_of_role(path, channels, names):
    """The layer with the first of `names` that is there."""
    layers = {}
    for channel in channels:
        if "." in channel:
            full = channel.rsplit(".", 1)[0]
            own = full.rsplit(".", 1)[-1].lower()
            layers.setdefault("".join(c for c in own if c.isalnum()), full)
    for name in names:
        found = layer(channels, layers[name]) if name in layers else None
        if found is not None:
            return found
    sys.exit(f"{path}: expected a layer called {' or '.join(names)}, found {' '.join(channels)}")


def read_stack(path, with_emission):
    """What OIDN gets, and what is added to what it gives: colour, albedo, normal, emission."""
    if os.path.isdir(path):
        return read_buckets(path)
    channels = read_channels(path)
    noisy, emission = layer(channels, "noisy"), layer(channels, "emission")
    if noisy is None:
        sys.exit(f"{path}: expected channels noisy.R, noisy.G, noisy.B: write the stack with --aov inputs")
    if emission is None:
        emission = np.zeros_like(noisy)
    if with_emission:
        noisy, emission = noisy + emission, np.zeros_like(emission)
    albedo, normal = (layer_of_role(path, channels, names) for names in (ALBEDO, NORMAL))
    return noisy, albedo, normal, emission


def read_buckets(folder):
    """Means over the buckets of a folder; they have no layer of emission."""
    sums, count = None, 0
    while os.path.exists(path := os.path.join(folder, f"b{count}.exr")):
        channels = read_channels(path)
        colour = layer(channels, "")
        if colour is None:
            colour = layer_of_role(path, channels, COLOUR)
        found = np.stack([colour, *(layer_of_role(path, channels, names) for names in (ALBEDO, NORMAL))])
        if sums is not None and sums.shape != found.shape:
            sys.exit(f"{path}: its size is not that of the buckets before")
        sums = found.astype(np.float64) + (0.0 if sums is None else sums)
        count += 1
    if sums is None:
        sys.exit(f"{folder}: expected buckets called b0.exr, b1.exr …")
    colour, albedo, normal = (np.ascontiguousarray(mean, dtype=np.float32) for mean in sums / count)
    return colour, albedo, normal, np.zeros_like(colour)


def sound(picture, least):
    """The picture with what is not finite, or below `least`, taken out."""
    return np.ascontiguousarray(np.maximum(np.nan_to_num(picture, nan=0.0, posinf=0.0, neginf=0.0), least))


# --- OIDN ------------------------------------------------------------------------------------------------------------


def run_filter(device, images, **flags):
    """The output of OIDN's filter for the images of these names, and the seconds it took."""
    output = np.empty_like(next(iter(images.values())))
    with pyoidn.Filter(device, pyoidn.OIDN_FILTER_TYPE_RT) as oidn:
        for name, image in (images | {pyoidn.OIDN_IMAGE_OUTPUT: output}).items():
            oidn.set_image(name, image, pyoidn.OIDN_FORMAT_FLOAT3)
        for flag, value in flags.items():
            oidn.set_bool(flag, value)
        oidn.set_quality(pyoidn.OIDN_QUALITY_HIGH)
        oidn.commit()
        start = time.perf_counter()
        oidn.execute()
        seconds = time.perf_counter() - start
    error = device.get_error()
    if error:
        sys.exit(f"OIDN: {error}")
    return output, seconds


def denoise(device, colour, albedo, normal, clean):
    """The denoised colour, with auxiliaries denoised first if `clean`, and the seconds of all filters."""
    total = 0.0
    auxiliaries = {pyoidn.OIDN_IMAGE_ALBEDO: albedo, pyoidn.OIDN_IMAGE_NORMAL: normal}
    if clean:
        for name, image in auxiliaries.items():
            auxiliaries[name], seconds = run_filter(device, {name: image})
            total += seconds
    images = {pyoidn.OIDN_IMAGE_COLOR: colour} | auxiliaries
    picture, seconds = run_filter(device, images, hdr=True, cleanAux=clean)
    return picture, total + seconds


def write_picture(path, picture):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    planes = {name: np.ascontiguousarray(picture[..., c]) for c, name in enumerate("RGB")}
    OpenEXR.File(header, planes).write(path)


# --- Command line ----------------------------------------------------------------------------------------------------


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stacks", nargs="+", metavar="STACK", help="an EXR file of Tamis's, or a folder of buckets")
    parser.add_argument("-o", "--output", default=".", help="folder of the pictures")
    parser.add_argument("--with-emission", action="store_true", help="denoise directly seen light with the rest")
    return parser.parse_args()


def main():
    options = parse_options()
    os.makedirs(options.output, exist_ok=True)
    with pyoidn.Device() as device:
        device.commit()
        for stack in options.stacks:
            name = os.path.splitext(os.path.basename(os.path.normpath(stack)))[0]
            colour, albedo, normal, emission = read_stack(stack, options.with_emission)
            inputs = sound(colour, 0.0), sound(albedo, 0.0), sound(normal, -1.0)
            for ending, clean in (("oidn", False), ("oidn-clean", True)):
                picture, seconds = denoise(device, *inputs, clean)
                path = os.path.join(options.output, f"{name}-{ending}.exr")
                write_picture(path, picture + emission)
                print(f"{path}: {seconds:.2f} s")


if __name__ == "__main__":
    main()
