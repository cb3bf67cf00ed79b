#!/usr/bin/env python3
"""Prints the table of stacks: what `tamis denoise` finds in each, the error of every denoiser, seconds and memory.

    cargo build
    python scripts/table_of_stacks.py STACK[=REF[,REF2]]… -o DIR [--oidn "python scripts/denoise_with_oidn.py"]

A STACK is a file of any renderer, several joined by commas, a folder of buckets b0.exr, b1.exr …, or another folder whose
files are one stack. Errors are relative MSE as `tamis compare` measures it (against two references, where there are two,
`rmse_cross`) / the same without the worst 0.1 % of pixels; `-` without a reference. Seconds and bytes a pixel are those of
the default, without reading and writing the one, with both the other. OIDN gets colour, albedo and normal as Tamis read
them, and the better of its two pictures counts.
"""

import argparse
import glob
import json
import os
import shlex
import subprocess
import sys

import tables
from measuring import call

METHODS = ["best", "nfor", "wlr", "apr"]


def run(command):
    print("$", " ".join(command), file=sys.stderr)
    return call(command, stdout=subprocess.PIPE, text=True).stdout


def inputs_of(stack):
    if not os.path.isdir(stack):
        return stack.split(",")
    buckets = []
    while os.path.exists(path := os.path.join(stack, f"b{len(buckets)}.exr")):
        buckets.append(path)
    return ["--buckets", *buckets] if buckets else sorted(glob.glob(os.path.join(stack, "*.exr")))


def name_of(stack):
    return os.path.splitext(os.path.basename(os.path.normpath(stack.split(",")[0])))[0]


def found_in_words(found):
    roles = [role["role"] for role in found["roles"] if role["role"] != "colour"]
    noise = next((role["noise"] for role in found["roles"] if role["role"] == "colour"), "unknown")
    return f"{found['renderer']}: {', '.join(roles) or 'colour alone'}; noise {noise}"


def pictures_of(options, stack, name):
    """Files by denoiser, and what `--json` says of the default."""
    denoise = [options.tamis, "denoise", *inputs_of(stack), "--quiet"]
    files = {key: os.path.join(options.output, f"{name}-{key}.exr") for key in ["ld", *METHODS]}
    report = json.loads(run([*denoise, "-o", files["best"], "--aov", "mse", "--json"]))
    for method in METHODS[1:]:
        run([*denoise, "-o", files[method], "--aov", "none", "--method", method])
    # The noisy picture, and what OIDN takes from it.
    run([*denoise, "-o", files["ld"], "--aov", "inputs", "--method", "ld"])
    if options.oidn and {"albedo", "normal"} <= {role["role"] for role in report["found"]["roles"]}:
        run([*shlex.split(options.oidn), files["ld"], "-o", options.output])
        for ending in ("oidn", "oidn-clean"):
            files[ending] = os.path.join(options.output, f"{name}-ld-{ending}.exr")
    return files, report


def errors_of(options, files, references):
    """Relative MSE and trimmed, by denoiser."""
    if not references:
        return {}
    second = ["--ref2", references[1]] if len(references) > 1 else []
    measure = "rmse_cross" if second else "rmse"
    report = json.loads(run([options.tamis, "compare", references[0], *files.values(), *second, "--json"]))
    return {key: (image[measure], image[measure + "_trimmed"]) for key, image in zip(files, report["images"])}


def row(options, stack, references):
    name = name_of(stack)
    files, report = pictures_of(options, stack, name)
    errors = errors_of(options, files, references)
    oidn = [errors[key] for key in ("oidn", "oidn-clean") if key in errors]
    if oidn:
        errors["oidn"] = min(oidn, key=lambda pair: pair[1])
    cells = [" / ".join(f"{value:.3g}" for value in errors[key]) if key in errors else "-" for key in ["ld", *METHODS, "oidn"]]
    pixels = report["width"] * report["height"]
    seconds = f"{sum(report['stages'].values()):.1f}"
    return [name, found_in_words(report["found"]), *cells, seconds, f"{report['peak_bytes'] / pixels:.0f}"]


def parse_options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stacks", nargs="+", metavar="STACK[=REF[,REF2]]")
    parser.add_argument("-o", "--output", required=True, help="folder of the pictures")
    parser.add_argument("--oidn", help="command that runs OIDN on a stack, with its output folder as -o")
    parser.add_argument("--tamis", default="target/debug/tamis", help="the program")
    return parser.parse_args()


def main():
    options = parse_options()
    os.makedirs(options.output, exist_ok=True)
    head = ["stack", "found", "noisy", *METHODS, "OIDN", "s", "B/px"]
    print(tables.head(head))
    for argument in options.stacks:
        stack, _, references = argument.partition("=")
        print(tables.line(row(options, stack, references.split(",") if references else [])), flush=True)


if __name__ == "__main__":
    main()
