"""Means, their errors, and pictures side by side."""

import math

import numpy as np
from PIL import Image


def mean_and_error(samples):
    """Mean over the first axis, and its standard error."""
    return samples.mean(axis=0), samples.std(axis=0, ddof=1) / math.sqrt(len(samples))


def write_side_by_side(path, tamis, mitsuba):
    """Tamis, Mitsuba, and 0.5 + ten times their difference, as a PNG."""
    gap = np.ones((tamis.shape[0], 4, 3))
    shown = [displayed(tamis), gap, displayed(mitsuba), gap, 0.5 + 10.0 * (displayed(tamis) - displayed(mitsuba))]
    Image.fromarray((np.clip(np.hstack(shown), 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)).save(path)


def displayed(picture):
    """sRGB of linear values."""
    clipped = np.clip(picture, 0.0, 1.0)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1.0 / 2.4) - 0.055)
