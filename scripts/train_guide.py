#!/usr/bin/env python3
"""Trains the network that judges guides (`tamis denoise --guide`), and writes its weights.

    pip install numpy
    tamis experiment guide FOLDER… -o DIR           writes a .lesson beside every picture
    python scripts/train_guide.py DIR/*.lesson -o crates/reconstruct/src/guide/weights.txt

A lesson is what the network is told about some pixels of a picture and its guide, and what a weight there costs
(`write_lesson` in crates/cli/src/experiment/guide/lesson.rs). The weights minimise, by Adam, the mean error of the mixture
over that of the better of picture and guide, every lesson alike: error(w) = ⟨x − r⟩² + w² ⟨d, d⟩ − 2 w ⟨d, t − x⟩.
The same lessons and seed give the same weights on one machine.
"""

import argparse
import sys

import numpy as np

HIDDEN = 24
COSTS = 4  # ⟨d, t − x⟩, ⟨d, d⟩, ⟨x − r₁, x − r₂⟩, error of the better picture
FURTHEST = 3.0  # deviations from the mean that an input may have
STEPS, BATCH, RATE, DECAY = 1000, 30, 0.01, 1e-3


def read_lesson(path, columns):
    """Inputs and costs of the pixels of one lesson."""
    numbers = np.fromfile(path, "<f4")
    if numbers.size == 0 or numbers.size % columns:
        sys.exit(f"{path}: expected rows of {columns} numbers, found {numbers.size} numbers in all")
    rows = numbers.reshape(-1, columns)
    return rows[:, :-COSTS], rows[:, -COSTS:]


def forward(network, inputs):
    """Hidden nodes and the weight of the guide."""
    weights, biases, output, bias = network
    hidden = np.tanh(inputs @ weights + biases)
    return hidden, 1.0 / (1.0 + np.exp(-(hidden @ output + bias[0])))


def gradients(network, inputs, costs):
    weights, _, output, _ = network
    hidden, weight = forward(network, inputs)
    slope = np.clip((2.0 * weight * costs[:, 1] - 2.0 * costs[:, 0]) / costs[:, 3], -20.0, 20.0)
    slope *= weight * (1.0 - weight) / len(inputs)
    inner = np.outer(slope, output) * (1.0 - hidden**2)
    decay = DECAY * weights, DECAY * output
    return [inputs.T @ inner + decay[0], inner.sum(0), hidden.T @ slope + decay[1], np.array([slope.sum()])]


def train(lessons, seed):
    """The network, and what inputs are normalised by."""
    random = np.random.default_rng(seed)
    everything = np.concatenate([inputs for inputs, _ in lessons])
    means, deviations = everything.mean(0), everything.std(0) + 1e-3
    standard = [np.clip((inputs - means) / deviations, -FURTHEST, FURTHEST) for inputs, _ in lessons]
    count = len(means)
    # It starts with little trust.
    network = [random.normal(0, 0.7 / np.sqrt(count), (count, HIDDEN)), np.zeros(HIDDEN), random.normal(0, 0.1, HIDDEN)]
    network.append(np.array([-2.0]))
    first, second = ([np.zeros_like(part) for part in network] for _ in range(2))
    for step in range(1, STEPS + 1):
        drawn = [random.integers(0, len(inputs), BATCH) for inputs in standard]
        inputs = np.concatenate([inputs[rows] for inputs, rows in zip(standard, drawn)])
        costs = np.concatenate([costs[rows] for (_, costs), rows in zip(lessons, drawn)])
        rate = RATE * (1.0 - 0.95 * step / STEPS)
        for i, gradient in enumerate(gradients(network, inputs, costs)):
            first[i] = 0.9 * first[i] + 0.1 * gradient
            second[i] = 0.999 * second[i] + 0.001 * gradient**2
            network[i] -= rate * (first[i] / (1 - 0.9**step)) / (np.sqrt(second[i] / (1 - 0.999**step)) + 1e-8)
    return network, means, deviations


def write(path, network, means, deviations):
    weights, biases, output, bias = network
    line = lambda name, values: name + "".join(f" {value:.7g}" for value in values)
    lines = ["# Written by `scripts/train_guide.py`; see weights.rs for the format.", f"tamis-guide 1 {len(means)} {HIDDEN}"]
    lines += [line("means", means), line("deviations", deviations)]
    lines += [line("hidden", [biases[j], *weights[:, j]]) for j in range(HIDDEN)]
    lines.append(line("output", [bias[0], *output]))
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


def gain(network, means, deviations, lesson):
    """Error of the mixture over that of the better picture, on the pixels of a lesson."""
    inputs, costs = lesson
    _, weight = forward(network, np.clip((inputs - means) / deviations, -FURTHEST, FURTHEST))
    error = costs[:, 2] + weight**2 * costs[:, 1] - 2.0 * weight * costs[:, 0]
    return error.mean() / costs[0, 3]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lessons", nargs="+", metavar="LESSON")
    parser.add_argument("-o", "--output", required=True, help="the weights file")
    parser.add_argument("--inputs", type=int, default=61, help="numbers the network is told")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    lessons = [read_lesson(path, options.inputs + COSTS) for path in options.lessons]
    trained = train(lessons, options.seed)
    write(options.output, *trained)
    gains = [gain(*trained, lesson) for lesson in lessons]
    print(f"{len(lessons)} lessons: error over that of the better picture {np.mean(gains):.3f} on average (seen in training)")


if __name__ == "__main__":
    main()
