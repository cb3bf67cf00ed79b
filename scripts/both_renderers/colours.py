"""Colours as Mitsuba takes them."""

from .mitsuba_variant import mi


def rgb(colour):
    return {"type": "rgb", "value": [float(c) for c in colour]}


def vector(colour):
    return mi.ScalarVector3f([float(c) for c in colour])
