"""Lights, as docs/scene-format.md documents `[[light]]`."""

import math

import numpy as np

from .colours import rgb
from .mitsuba_variant import mi


def lamp(light):
    """Mitsuba's description of a light. Its disks and spheres are round, not flat-faced."""
    kind, at = light["type"], light.get("position")
    if kind == "point":
        return {"type": "point", "position": at, "intensity": rgb(light["intensity"])}
    if kind == "spot":
        return spot(light)
    if kind == "sun":
        return sun(light)
    if kind == "quad":
        a, b = light["size"]
        return emitting({"type": "rectangle", "to_world": facing(light, [a / 2.0, b / 2.0])}, a * b, light)
    radius = light["radius"]
    area = math.pi * radius**2
    if kind == "disk":
        return emitting({"type": "disk", "to_world": facing(light, [radius, radius])}, area, light)
    assert kind == "sphere", kind
    return emitting({"type": "sphere", "center": at, "radius": radius}, 4.0 * area, light)


def emitting(described, area, light):
    """A shape that reflects nothing and emits on its outside."""
    radiance = light["radiance"] if "radiance" in light else [p / (math.pi * area) for p in light["power"]]
    described["bsdf"] = {"type": "diffuse", "reflectance": rgb([0.0, 0.0, 0.0])}
    return described | {"emitter": {"type": "area", "radiance": rgb(radiance)}}


def facing(light, scale=(1.0, 1.0)):
    """Takes the origin to where a light is and z to its axis, and first scales x and y."""
    at, target, up = light["position"], light["look_at"], light.get("up", [0.0, 1.0, 0.0])
    if not np.cross(np.subtract(target, at), up).any():
        up = [1.0, 0.0, 0.0]
    placed = mi.ScalarTransform4f().look_at(origin=at, target=target, up=up)
    return placed @ mi.ScalarTransform4f().scale([*scale, 1.0])


SPOT_PICTURE = 2048


def spot(light):
    """With a hard edge, and the smooth step in the cosine as a picture, whose sides are at the edge."""
    rim, fade = light.get("cone_angle", 30.0), light.get("cone_delta_angle", 5.0)
    described = {"type": "spot", "cutoff_angle": rim, "beam_width": rim, "to_world": facing(light)}
    described["intensity"] = rgb(light["intensity"])
    if fade > 0.0:
        places = (2.0 * (np.arange(SPOT_PICTURE) + 0.5) / SPOT_PICTURE - 1.0) * math.tan(math.radians(rim))
        cosine = 1.0 / np.sqrt(1.0 + places[:, None] ** 2 + places[None, :] ** 2)
        low, high = math.cos(math.radians(rim)), math.cos(math.radians(rim - fade))
        t = np.clip((cosine - low) / (high - low), 0.0, 1.0)
        smooth = mi.Bitmap((t * t * (3.0 - 2.0 * t)).astype(np.float32)[..., None])
        described["texture"] = {"type": "bitmap", "bitmap": smooth, "raw": True, "wrap_mode": "clamp"}
    return described


# How far a sun is away. Nearer, it would move with the place; farther, single precision would move its rim.
FAR = 1e5


def sun(light):
    half, direction = math.radians(light.get("angle", 0.53)) / 2.0, light["direction"]
    if half == 0.0:
        return {"type": "directional", "direction": direction, "irradiance": rgb(light["irradiance"])}
    at = -FAR * np.array(direction) / np.linalg.norm(direction)
    radiance = [e / (math.pi * math.sin(half) ** 2) for e in light["irradiance"]]
    described = {"type": "disk", "position": at.tolist(), "look_at": [0.0, 0.0, 0.0], "radius": FAR * math.tan(half)}
    return lamp(described | {"radiance": radiance})
