#!/usr/bin/env python3
"""Trains the network that says how far `tamis denoise --guide` follows a guide.

    tamis experiment guide FOLDER… -o DIR          (writes DIR/*.lesson, a file for each stack and guide)
    python scripts/train_guide.py DIR… -o crates/reconstruct/src/blend/weights.txt

A lesson holds rows of little-endian 32-bit floats: the network's inputs at a pixel, what is added to the logit of its
weight there (crates/reconstruct/src/blend/stakes.rs), then N = <d, t − x>, D = <d, d> and E = <x − r1, x − r2> there, and the error of the better of picture and guide (crates/cli/src/experiment/guide/lesson.rs).
A weight w costs E + w²D − 2wN; the loss is the mean of w²D − 2wN over that error. Several networks are trained, each from
weights of its own, and their logits are averaged: one network of all their nodes. Needs numpy; a minute or two on one core. The
same seed gives the same weights on the same machine.
"""

import argparse
import glob
import os
import sys

from packages import need

need(__doc__, "numpy")

import numpy as np  # noqa: E402

INPUTS = 61
# Networks, and hidden nodes of each.
MEMBERS = 4
NODES = 24
STEPS = 1000
# Rows of every lesson that make a step.
BATCH = 30
RATE = 0.015
DECAY = 1e-3
# Inputs are cut off this many deviations from their mean, as in judge.rs.
FURTHEST = 3.0
# Slopes of one pixel are cut off here.
STEEPEST = (-20.0, 40.0)
# How much lessons of a guide count; others count 1.
COUNTS = {"oidn": 6.0, "oidn-clean": 4.0, "oidn-colour": 4.0, "a_reference": 0.7, "black": 0.5, "noisy_blurred_more": 0.5}
# Guides that are no denoiser's result: their harm counts this much more than their help.
CAUTION = 1.8
CAUTIOUS = ("blurred", "noise", "noisy", "nfor")
# Nothing is to be learned from a black guide but to leave it alone.
BLACK = "black"


def read_lessons(folders):
    """Rows, loss weights and names of all lessons; rows are cut to the shortest lesson."""
    lessons = []
    for path in sorted(path for folder in folders for path in glob.glob(os.path.join(folder, "*.lesson"))):
        rows = np.fromfile(path, "<f4").reshape(-1, INPUTS + 5)
        lessons.append((os.path.basename(path)[: -len(".lesson")], rows))
    if not lessons:
        sys.exit(f"{' '.join(folders)}: no *.lesson, which `tamis experiment guide` writes")
    count = min(len(rows) for _, rows in lessons)
    random = np.random.default_rng(5)
    return [(name, rows[random.permutation(len(rows))[:count]]) for name, rows in lessons]


def kind_of(name):
    """The guide's kind: what follows the stack's name. Kinds are known by how they end."""
    known = [*COUNTS, "fast", "nfor", "noisy", "noisy_blurred", "ours_blurred", "oidn_blurred", "oidn_darker"]
    known += ["oidn_with_noise", "a_reference_with_noise"]
    fitting = [kind for kind in known if name.endswith("-" + kind)]
    return max(fitting, key=len, default="")


class Batches:
    """All lessons as arrays: standardised inputs with their means and deviations, N, D, the factor on each lesson's loss."""

    def __init__(self, lessons):
        kinds = [kind_of(name) for name, _ in lessons]
        rows = np.stack([rows for _, rows in lessons])
        sample = rows[:, :200, :INPUTS].reshape(-1, INPUTS)
        self.means, self.deviations = sample.mean(0), sample.std(0) + np.float32(1e-3)
        self.inputs = np.clip((rows[..., :INPUTS] - self.means) / self.deviations, -FURTHEST, FURTHEST)
        self.stake = rows[..., INPUTS]
        self.gain, self.cost = rows[..., INPUTS + 1], rows[..., INPUTS + 2]
        caution = [CAUTION if any(word in kind for word in CAUTIOUS) else 1.0 for kind in kinds]
        self.cost = self.cost * np.float32(caution)[:, None]
        black = np.array([kind == BLACK for kind in kinds])
        self.gain = np.where(black[:, None], np.minimum(self.gain, 0), self.gain)
        counts = np.float32([COUNTS.get(kind, 1.0) for kind in kinds])
        self.factor = (counts / rows[:, 0, INPUTS + 4])[:, None]


def train(batches, seed):
    """Parameters of one network (hidden weights, hidden biases, output weights, output bias) by Adam."""
    random = np.random.default_rng(seed)
    parameters = [
        random.normal(0, 0.7 / np.sqrt(INPUTS), (INPUTS, NODES)),
        np.zeros(NODES),
        random.normal(0, 0.1, NODES),
        np.array([-2.0]),
    ]
    parameters = [p.astype(np.float32) for p in parameters]
    first, second = ([np.zeros_like(p) for p in parameters] for _ in range(2))
    for step in range(STEPS):
        at = random.integers(0, batches.inputs.shape[1] - BATCH)
        rows = slice(at, at + BATCH)
        gain, cost = ((plane[:, rows] * batches.factor).ravel() for plane in (batches.gain, batches.cost))
        stake = batches.stake[:, rows].ravel()
        slopes = gradient(parameters, batches.inputs[:, rows].reshape(-1, INPUTS), stake, gain, cost)
        rate = RATE * (1 - 0.95 * step / STEPS)
        for i, slope in enumerate(slopes):
            slope = slope + DECAY * parameters[i] * (i in (0, 2))
            first[i] = 0.9 * first[i] + 0.1 * slope
            second[i] = 0.999 * second[i] + 0.001 * slope * slope
            unbiased = first[i] / (1 - 0.9 ** (step + 1)), second[i] / (1 - 0.999 ** (step + 1))
            parameters[i] = (parameters[i] - rate * unbiased[0] / (np.sqrt(unbiased[1]) + 1e-8)).astype(np.float32)
    return parameters


def gradient(parameters, inputs, stake, gain, cost):
    hidden_weights, hidden_biases, output_weights, output_bias = parameters
    hidden = np.tanh(inputs @ hidden_weights + hidden_biases)
    weight = 1 / (1 + np.exp(-(stake + hidden @ output_weights + output_bias[0])))
    slope = np.clip(2 * weight * cost - 2 * gain, *STEEPEST)
    slope = (slope * weight * (1 - weight) / len(inputs)).astype(np.float32)
    back = slope[:, None] * output_weights * (1 - hidden * hidden)
    return inputs.T @ back, back.sum(0), hidden.T @ slope, np.array([slope.sum()])


def committee(members):
    """One network whose logit is the mean of the members'."""
    hidden_weights, hidden_biases, output_weights, output_biases = zip(*members)
    outputs = np.concatenate(output_weights) / len(members)
    return np.concatenate(hidden_weights, axis=1), np.concatenate(hidden_biases), outputs, np.mean(output_biases, axis=0)


def write(path, means, deviations, parameters):
    hidden_weights, hidden_biases, output_weights, output_bias = parameters
    nodes = len(hidden_biases)
    lines = ["# Written by `scripts/train_guide.py`; see weights.rs for the format.", f"tamis-guide 1 {INPUTS} {nodes}"]
    add = lambda name, numbers: lines.append(" ".join([name, *(str(np.float32(v)) for v in numbers)]))
    add("means", means)
    add("deviations", deviations)
    for node in range(nodes):
        add("hidden", [hidden_biases[node], *hidden_weights[:, node]])
    add("output", [output_bias[0], *output_weights])
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", metavar="DIR", help="folders of lessons; one given twice counts twice")
    parser.add_argument("-o", "--output", required=True, metavar="FILE", help="the weights")
    parser.add_argument("--seed", type=int, default=100, help="of the first network; each has the next one")
    options = parser.parse_args()
    lessons = read_lessons(options.folders)
    print(f"{len(lessons)} lessons of {len(lessons[0][1])} pixels")
    batches = Batches(lessons)
    members = [train(batches, options.seed + number) for number in range(MEMBERS)]
    write(options.output, batches.means, batches.deviations, committee(members))


if __name__ == "__main__":
    main()
