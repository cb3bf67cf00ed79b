"""The trapezoid rule."""

import numpy as np


def trapezoid(y, x):
    """∫ y dx; numpy's own has another name in every major version."""
    return float(((y[1:] + y[:-1]) * np.diff(x)).sum() / 2.0)
