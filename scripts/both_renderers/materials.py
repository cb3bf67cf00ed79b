"""Materials of MTL files as Mitsuba's, as crates/tracer/src/scene/mtl documents them."""

import math
import os
import sys

import numpy as np

from .colours import rgb, vector


def numbers(entry, key, default=None):
    """One to three numbers as a colour ≥ 0; `default` where nothing is said."""
    if key not in entry:
        return default
    values = [float(w) for w in entry[key][:3]]
    return np.maximum(np.array(values if len(values) == 3 else values[:1] * 3), 0.0)


def number(entry, key, default=None):
    return float(entry[key][0]) if key in entry else default


def roughness(entry):
    """GGX α: Pr², else √(2/(Ns + 2)); None where nothing is said."""
    pr, ns = number(entry, "pr"), number(entry, "ns", 0.0)
    if pr is not None:
        return min(max(pr * pr, 0.0), 1.0)
    return math.sqrt(2.0 / (ns + 2.0)) if ns > 0.0 else None


def reflectances(entry):
    """Kd and Ks; what only shines or only reflects is black otherwise, what says nothing is grey."""
    specular = numbers(entry, "ks", np.zeros(3))
    bare = np.zeros(3) if "ke" in entry or specular.any() else np.full(3, 0.5)
    return numbers(entry, "kd", bare), specular


def bsdf(name, entry, folder):
    """Mitsuba's description of a material."""
    unsupported = [k for k in entry if k.startswith(("map_", "bump", "norm")) and k not in ("map_kd", "map_d")]
    if unsupported:
        sys.exit(f"material '{name}': {', '.join(unsupported)} cannot be compared")
    described = surface(entry, folder)
    if "map_d" not in entry:
        return described
    return {"type": "mask", "opacity": bitmap(entry["map_d"], folder, raw=True), "bsdf": described}


def surface(entry, folder):
    """The same without its holes."""
    model, alpha = number(entry, "illum"), roughness(entry)
    diffuse, specular = reflectances(entry)
    opacity = number(entry, "d", 1.0 - number(entry, "tr", 0.0))
    if "map_kd" in entry:
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": bitmap(entry["map_kd"], folder)}}
    if number(entry, "pm", 0.0) >= 1.0:
        return metal(diffuse if diffuse.any() else specular, alpha)
    if model == 5:
        return mirror(specular if specular.any() else diffuse)
    if model in (4, 6, 7, 9) or (opacity < 1.0 and "ni" in entry):
        return glass(entry)
    if model in (None, 3, 8) and specular.any() and not diffuse.any():
        return metal(specular, alpha)
    return opaque(entry, diffuse, specular, alpha)


def bitmap(words, folder, raw=False):
    """A texture, repeated and bilinear; `raw` when it holds no sRGB colours."""
    return {"type": "bitmap", "filename": os.path.join(folder, " ".join(words)), "raw": raw}


def opaque(entry, diffuse, specular, alpha):
    """Diffuse, or under a coat where there is a highlight; both scaled to at most 1 together."""
    metallic = min(max(number(entry, "pm", 0.0), 0.0), 1.0)
    if not specular.any() and ("pr" in entry or metallic > 0.0):
        specular = np.full(3, 0.04)
    shows_highlights = number(entry, "illum") not in (0, 1) or "pr" in entry
    if alpha is None or not shows_highlights or not specular.any():
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(np.minimum(diffuse, 1.0))}}
    specular = specular + metallic * (diffuse - specular)
    diffuse = diffuse * (1.0 - metallic)
    scale = 1.0 / max(1.0, (diffuse + specular).max())
    return coat(diffuse * scale, specular * scale, alpha)


def metal(reflectance, alpha):
    """Rough metal with Schlick's Fresnel; a smooth one is a mirror, without."""
    if alpha is None or alpha < 0.01:
        return mirror(reflectance)
    compensated = {"type": "tamis_compensated", "alpha": float(alpha), "reflectance": vector(np.minimum(reflectance, 1.0))}
    return {"type": "twosided", "bsdf": compensated}


def mirror(reflectance):
    perfect = {"type": "conductor", "material": "none", "specular_reflectance": rgb(np.minimum(reflectance, 1.0))}
    return {"type": "twosided", "bsdf": perfect}


def glass(entry):
    tint = np.minimum(numbers(entry, "tf", np.ones(3)), 1.0)
    ior, pr = number(entry, "ni", 1.5), number(entry, "pr", 0.0)
    if number(entry, "illum") in (4, 9):
        return {"type": "thindielectric", "int_ior": ior, "ext_ior": 1.0, "specular_transmittance": rgb(tint)}
    if pr * pr >= 1e-3:
        return {"type": "tamis_compensated", "alpha": pr * pr, "ior": ior, "tint": vector(tint)}
    return {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0, "specular_transmittance": rgb(tint)}


def coat(diffuse, specular, alpha):
    return {"type": "tamis_coat", "diffuse": vector(diffuse), "specular": vector(specular), "alpha": float(alpha)}
