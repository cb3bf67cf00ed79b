"""One scene rendered by Tamis and by Mitsuba 3, for the scripts beside this file.

For Mitsuba, geometry and materials are read anew from OBJ and MTL files, as Tamis documents them; no code is shared with
Tamis. Needs mitsuba, numpy, openexr and pillow.

Mitsuba needs a libLLVM of version 17 or later (older ones stop with "Cannot select … fminimum"). Unless
DRJIT_LIBLLVM_PATH names one, the one in the Rust toolchain is taken.

What Mitsuba has no equal of is built here, from its documented formula:

* `Coat`, a diffuse base under a GGX coat (crates/tracer/src/bsdf/coated.rs; Mitsuba's `plastic`, `roughplastic` and
  `principled` have other bases), with albedos of its own quadrature.
* `Compensated`, Mitsuba's own `roughconductor` or `roughdielectric` times the light that facets scatter more than once,
  which Tamis gives back and Mitsuba does not (crates/tracer/src/bsdf/conductor.rs, rough_glass.rs). The albedos for it
  are those of Mitsuba's own sampling.
* The smooth edge of a spot, whose falloff is linear in the angle in Mitsuba: a picture before a spot with a hard edge.
* A sun of some size: a disk so far away that nothing in the scene sees it elsewhere.

Read are textures of the diffuse colour and of opacity; others are an error.
"""

import dataclasses
import glob
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np
import OpenEXR
from PIL import Image


def rust_llvm():
    """The libLLVM of the Rust toolchain, where there is one."""
    try:
        told = subprocess.run(["rustc", "--print", "sysroot"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return []
    return sorted(glob.glob(os.path.join(told.stdout.strip(), "lib", "libLLVM.so.*")))


# It is looked for once, when Mitsuba is imported.
for found in rust_llvm()[:1]:
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", found)
import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402

mi.set_variant("llvm_ad_rgb")


# --- OBJ and MTL -----------------------------------------------------------------------------------------------------


def statements(path):
    """Key and words of each statement; comments and continued lines resolved."""
    with open(path, encoding="utf-8", errors="replace") as file:
        text = file.read().replace("\\\n", " ")
    for line in text.splitlines():
        words = line.split("#", 1)[0].split()
        if words:
            yield words[0], words[1:]


def read_mtl(path):
    """Statements of each material, by name and lower-case key."""
    materials = {}
    for key, words in statements(path):
        if key.lower() == "newmtl":
            entry = materials.setdefault(" ".join(words), {})
        elif materials:
            entry[key.lower()] = words
    return materials


@dataclasses.dataclass
class Part:
    """Triangles of one material: three (position, uv, normal) triples of indices each, None for what there is not."""

    material: str
    triangles: list = dataclasses.field(default_factory=list)


@dataclasses.dataclass
class Obj:
    """What an OBJ file holds."""

    positions: np.ndarray
    uvs: np.ndarray
    normals: np.ndarray
    parts: list
    materials: dict
    folder: str


def read_obj(path):
    """Vertices, parts and materials of an OBJ file."""
    positions, uvs, normals, parts, materials, material = [], [], [], {}, {}, ""
    folder = os.path.dirname(path)
    for key, words in statements(path):
        if key == "v":
            positions.append([float(w) for w in words[:3]])
        elif key == "vt":
            uvs.append([float(w) for w in words[:2]])
        elif key == "vn":
            normals.append([float(w) for w in words[:3]])
        elif key == "mtllib":
            materials |= read_mtl(os.path.join(folder, " ".join(words)))
        elif key == "usemtl":
            material = " ".join(words)
        elif key == "f":
            corners = [corner(word, (len(positions), len(uvs), len(normals))) for word in words]
            known = tuple(all(c[kind] is not None for c in corners) for kind in (1, 2))
            part = parts.setdefault((material, known), Part(material))
            fan = zip(corners[1:], corners[2:])
            part.triangles += [(corners[0], b, c) for b, c in fan]
    arrays = (np.array(values) for values in (positions, uvs, normals))
    return Obj(*arrays, list(parts.values()), materials, folder)


def corner(word, counts):
    """Zero-based indices of position, uv and normal of a face's corner; negative ones count from the end."""
    fields = (word.split("/") + ["", ""])[:3]
    return tuple(index(int(f), n) if f else None for f, n in zip(fields, counts))


def index(number, count):
    return number - 1 if number > 0 else number + count


# --- Materials, as crates/tracer/src/scene/mtl documents them --------------------------------------------------------


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


def rgb(colour):
    return {"type": "rgb", "value": [float(c) for c in colour]}


def vector(colour):
    return mi.ScalarVector3f([float(c) for c in colour])


# --- The coat --------------------------------------------------------------------------------------------------------


def smith_lambda(cosine, alpha):
    """Λ of GGX (Heitz 2014, equation 72), in double precision."""
    tan2 = 1.0 / (cosine * cosine) - 1.0
    return 0.5 * (np.sqrt(1.0 + alpha * alpha * tan2) - 1.0)


def split_albedo(cosine, alpha, steps=512):
    """Directional albedo of a GGX coat with Fresnel 1, and with (1 − o·h)⁵ in its place.

    ∫ F G₂ D (o·h)/cos θₒ dω_h over microfacet normals, tan²θ_h = α² t/(1 − t), for which D cos θ_h dω_h = dt dφ/2π.
    The midpoints in t crowd at 1, at the steep normals that matter near the horizon.
    """
    s = (np.arange(steps) + 0.5) / steps
    t, density = 1.0 - s**3, 3.0 * s**2
    phi = (np.arange(steps // 2) + 0.5) / (steps // 2) * math.pi
    cos_h = (1.0 / np.sqrt(1.0 + alpha * alpha * t / (1.0 - t)))[:, None]
    sin_h = np.sqrt(1.0 - cos_h * cos_h)
    facet = math.sqrt(1.0 - cosine * cosine) * sin_h * np.cos(phi) + cosine * cos_h
    leaving = 2.0 * facet * cos_h - cosine
    valid = (facet > 0.0) & (leaving > 0.0)
    masking = 1.0 / (1.0 + smith_lambda(cosine, alpha) + smith_lambda(np.where(valid, leaving, 1.0), alpha))
    weight = np.where(valid, masking * facet / (cosine * cos_h), 0.0) * density[:, None]
    return weight.mean(), (weight * (1.0 - np.clip(facet, 0.0, 1.0)) ** 5).mean()


def trapezoid(y, x):
    """∫ y dx; numpy's own has another name in every major version."""
    return float(((y[1:] + y[:-1]) * np.diff(x)).sum() / 2.0)


class AlbedoTable:
    """E(cos) of a coat, per channel, at even places of cos^¼; and its cosine-weighted mean."""

    PLACES = 128

    def __init__(self, specular, alpha):
        places = np.linspace(0.0, 1.0, self.PLACES)
        perfect, grazing = np.array([split_albedo(max(p, 1e-2) ** 4, alpha) for p in places]).T
        albedos = [f0 * perfect + (1.0 - f0) * grazing for f0 in specular]
        fine = np.linspace(0.0, 1.0, 20001)
        means = [trapezoid(np.interp(fine, places, e) * 8.0 * fine**7, fine) for e in albedos]
        self.mean = mi.Color3f(*[float(m) for m in means])
        self.channels = [mi.Float(e.astype(np.float32)) for e in albedos]

    def at(self, cosine):
        place = dr.sqrt(dr.sqrt(dr.clip(cosine, 0.0, 1.0))) * (self.PLACES - 1)
        before = dr.minimum(mi.UInt32(place), self.PLACES - 2)
        share = place - mi.Float(before)
        low = [dr.gather(mi.Float, e, before) for e in self.channels]
        high = [dr.gather(mi.Float, e, before + 1) for e in self.channels]
        return mi.Color3f(*[a + share * (b - a) for a, b in zip(low, high)])


class Coat(mi.BSDF):
    """f = D F G₂/(4 cos cos) + k_d/π (1 − E(o))(1 − E(i))/(1 − Ē), on both sides (crates/tracer/src/bsdf/coated.rs).

    F is Schlick's, D and the height-correlated G₂ are GGX's. Sampled half by cosine, half by D cos θ_h: not as Tamis.
    """

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.specular = mi.Color3f(props["specular"])
        self.alpha = max(float(props["alpha"]), 1e-3)
        self.albedo = AlbedoTable([float(c) for c in props["specular"]], self.alpha)
        self.base = mi.Color3f(props["diffuse"]) / dr.maximum(1.0 - self.albedo.mean, 1e-30)
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [flags]
        self.m_flags = flags

    def facet_density(self, h):
        stretched = (h.x * h.x + h.y * h.y) / self.alpha**2 + h.z * h.z
        return dr.inv_pi / (self.alpha**2 * stretched * stretched)

    def shadowing(self, direction):
        tan2 = (direction.x * direction.x + direction.y * direction.y) / (direction.z * direction.z)
        return 0.5 * (dr.sqrt(1.0 + self.alpha**2 * tan2) - 1.0)

    def value_and_pdf(self, wi, wo, active):
        """f cos θ and density for local directions, of which both must lie on one side."""
        wi, wo = dr.mulsign(wi, wi.z), dr.mulsign(wo, wi.z)
        active &= (wi.z > 0.0) & (wo.z > 0.0)
        h = dr.normalize(wi + wo)
        facet = dr.clip(dr.dot(wi, h), 1e-9, 1.0)
        density = self.facet_density(h)
        fresnel = self.specular + (1.0 - self.specular) * (1.0 - facet) ** 5
        masking = 1.0 / (1.0 + self.shadowing(wi) + self.shadowing(wo))
        coat = fresnel * (density * masking / (4.0 * wi.z))
        base = self.base * (1.0 - self.albedo.at(wi.z)) * (1.0 - self.albedo.at(wo.z)) * (wo.z * dr.inv_pi)
        pdf = 0.5 * wo.z * dr.inv_pi + 0.5 * density * h.z / (4.0 * facet)
        return dr.select(active, coat + base, 0.0), dr.select(active, pdf, 0.0)

    def sample_half(self, sample):
        tan2 = self.alpha**2 * sample.x / dr.maximum(1.0 - sample.x, 1e-9)
        z = dr.rsqrt(1.0 + tan2)
        s, c = dr.sincos(dr.two_pi * sample.y)
        r = dr.safe_sqrt(1.0 - z * z)
        return mi.Vector3f(r * c, r * s, z)

    def sample(self, ctx, si, sample1, sample2, active=True):
        up = dr.mulsign(si.wi, si.wi.z)
        h = self.sample_half(sample2)
        reflected = 2.0 * dr.dot(up, h) * h - up
        wo = dr.select(sample1 < 0.5, mi.warp.square_to_cosine_hemisphere(sample2), reflected)
        wo = dr.mulsign(wo, si.wi.z)
        value, pdf = self.value_and_pdf(si.wi, wo, active)
        sampled = dr.zeros(mi.BSDFSample3f)
        sampled.wo, sampled.pdf, sampled.eta = wo, pdf, 1.0
        sampled.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        sampled.sampled_component = 0
        return sampled, dr.select(pdf > 0.0, value / pdf, 0.0)

    def eval(self, ctx, si, wo, active=True):
        return self.value_and_pdf(si.wi, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.value_and_pdf(si.wi, wo, active)[1]

    def eval_pdf(self, ctx, si, wo, active=True):
        return self.value_and_pdf(si.wi, wo, active)

    def traverse(self, callback):
        pass

    def to_string(self):
        return f"Coat[specular={self.specular}, alpha={self.alpha}]"


mi.register_bsdf("tamis_coat", Coat)


# --- Multiple scattering ----------------------------------------------------------------------------------------------


class Compensated(mi.BSDF):
    """Rough metal or glass of Mitsuba's, with what facets scatter more than once given back (Turquin 2019).

    With E the albedo towards the viewer: metal is multiplied by 1 + F₀ (1 − E)/E, and by Schlick's Fresnel, which Mitsuba
    does not know; glass by 1/E, reflection and refraction together.
    """

    PLACES = 96
    SIDE = 256

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        alpha = float(props["alpha"])
        self.reflectance = mi.Color3f(props["reflectance"]) if props.has_property("reflectance") else None
        if self.reflectance is not None:
            described = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": alpha}
        else:
            described = {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha, "ext_ior": 1.0}
            described |= {"int_ior": float(props["ior"]), "specular_transmittance": rgb(props["tint"])}
        self.nested = mi.load_dict(described)
        # The albedo is that of clear glass: tint takes light away, facets must not.
        clear = {k: v for k, v in described.items() if k != "specular_transmittance"}
        self.albedos = [self.tabulate(mi.load_dict(clear), side) for side in (1.0, -1.0)]
        self.m_components = [self.nested.flags(i) for i in range(self.nested.component_count())]
        self.m_flags = self.nested.flags()

    def tabulate(self, nested, side):
        """E at even places of cos^¼, seen from outside or from inside: the mean weight of samples on a grid."""
        if side < 0.0 and self.reflectance is not None:
            return mi.Float([1.0] * self.PLACES)
        of_each = self.SIDE * self.SIDE
        i = dr.arange(mi.UInt32, self.PLACES * of_each)
        cosine = dr.maximum(mi.Float(i // of_each) / (self.PLACES - 1), 1e-2) ** 4
        x, y = mi.Float(i % self.SIDE), mi.Float(i // self.SIDE % self.SIDE)
        u = mi.Point2f((x + 0.5) / self.SIDE, (y + 0.5) / self.SIDE)
        si = dr.zeros(mi.SurfaceInteraction3f, self.PLACES * of_each)
        si.wi = mi.Vector3f(dr.safe_sqrt(1.0 - cosine * cosine), 0.0, side * cosine)
        # Importance is not scaled by η².
        context = mi.BSDFContext(mi.TransportMode.Importance)
        # Reflection or refraction: the golden ratio's multiples, which no grid knows.
        choice = mi.Float(i % of_each) * 0.6180339887
        choice -= dr.floor(choice)
        _, weight = nested.sample(context, si, choice, u)
        means = np.array(weight[0]).reshape(self.PLACES, of_each).mean(axis=1)
        return mi.Float(means.astype(np.float32))

    def factor(self, wi, wo):
        place = dr.sqrt(dr.sqrt(dr.clip(dr.abs(wi.z), 0.0, 1.0))) * (self.PLACES - 1)
        before = dr.minimum(mi.UInt32(place), self.PLACES - 2)
        share = place - mi.Float(before)
        low, high = ([dr.gather(mi.Float, e, before + step) for e in self.albedos] for step in (0, 1))
        sides = [a + share * (b - a) for a, b in zip(low, high)]
        albedo = dr.select(wi.z > 0.0, sides[0], sides[1])
        if self.reflectance is None:
            return mi.Color3f(1.0 / albedo)
        facet = dr.clip(dr.dot(wi, dr.normalize(wi + wo)), 0.0, 1.0)
        fresnel = self.reflectance + (1.0 - self.reflectance) * (1.0 - facet) ** 5
        return fresnel * (1.0 + self.reflectance * ((1.0 - albedo) / albedo))

    def sample(self, ctx, si, sample1, sample2, active=True):
        sampled, weight = self.nested.sample(ctx, si, sample1, sample2, active)
        return sampled, weight * self.factor(si.wi, sampled.wo)

    def eval(self, ctx, si, wo, active=True):
        return self.nested.eval(ctx, si, wo, active) * self.factor(si.wi, wo)

    def pdf(self, ctx, si, wo, active=True):
        return self.nested.pdf(ctx, si, wo, active)

    def eval_pdf(self, ctx, si, wo, active=True):
        value, pdf = self.nested.eval_pdf(ctx, si, wo, active)
        return value * self.factor(si.wi, wo), pdf

    def traverse(self, callback):
        pass

    def to_string(self):
        return f"Compensated[{self.nested}]"


mi.register_bsdf("tamis_compensated", Compensated)


# --- What is rendered -------------------------------------------------------------------------------------------------


@dataclasses.dataclass
class View:
    """A scene file with a camera, and what both renderers must do with it."""

    scene: str
    eye: list
    look_at: list
    up: list = dataclasses.field(default_factory=lambda: [0.0, 1.0, 0.0])
    fov: float = 45.0
    size: list = dataclasses.field(default_factory=lambda: [128, 128])
    lens_radius: float = 0.0
    focus_distance: float = 1.0
    environment: str | None = None
    # Tables of `[[light]]`, as docs/scene-format.md documents them.
    lights: list = dataclasses.field(default_factory=list)
    max_depth: int = 8
    # Mitsuba's samples for each of Tamis's, where it is that much noisier.
    mitsuba_samples: int = 1


# --- Lights, as docs/scene-format.md documents `[[light]]` ------------------------------------------------------------


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


# --- Mitsuba ----------------------------------------------------------------------------------------------------------


def write_ply(path, part, obj):
    """The part as a PLY file; whether it has normals."""
    corners = [c for triangle in part.triangles for c in triangle]
    unique = {c: i for i, c in enumerate(dict.fromkeys(corners))}
    textured, smooth = corners[0][1] is not None, corners[0][2] is not None
    mesh = mi.Mesh(
        "part", len(unique), len(part.triangles), has_vertex_normals=smooth, has_vertex_texcoords=textured
    )
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = obj.positions[[p for p, _, _ in unique]].astype(np.float32).ravel()
    if textured:
        # Textures' first row is at v = 1 in OBJ, at v = 0 in Mitsuba.
        of_vertices = obj.uvs[[uv for _, uv, _ in unique]] * [1.0, -1.0] + [0.0, 1.0]
        parameters["vertex_texcoords"] = of_vertices.astype(np.float32).ravel()
    if smooth:
        of_vertices = obj.normals[[n for _, _, n in unique]]
        of_vertices /= np.linalg.norm(of_vertices, axis=1, keepdims=True)
        parameters["vertex_normals"] = of_vertices.astype(np.float32).ravel()
    parameters["faces"] = np.array([unique[c] for c in corners], dtype=np.uint32)
    parameters.update()
    mesh.write_ply(path)
    return smooth


def shape(path, part, obj):
    """A part as Mitsuba's shape. Lamps emit around the geometric normal in Tamis, so they get no others here."""
    entry = obj.materials.get(part.material, {})
    smooth = write_ply(path, part, obj)
    emission = numbers(entry, "ke", np.zeros(3))
    described = {"type": "ply", "filename": path, "face_normals": not smooth or bool(emission.any())}
    described["bsdf"] = bsdf(part.material, entry, obj.folder)
    if emission.any():
        described["emitter"] = {"type": "area", "radiance": rgb(emission)}
    return described


def mitsuba_scene(view, folder):
    """The scene, loaded; `folder` takes its meshes."""
    obj = read_obj(view.scene)
    described = {"type": "scene", "sensor": sensor(view)}
    described["integrator"] = {"type": "path", "max_depth": view.max_depth + 1, "rr_depth": 100000}
    if view.environment:
        described["sky"] = {"type": "envmap", "filename": view.environment}
    described |= {f"light{i}": lamp(light) for i, light in enumerate(view.lights)}
    for i, part in enumerate(obj.parts):
        described[f"part{i}"] = shape(os.path.join(folder, f"part{i}.ply"), part, obj)
    return mi.load_dict(described)


def sensor(view):
    width, height = view.size
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "component_format": "float32"}
    film["rfilter"] = {"type": "box"}
    described = {
        "type": "perspective",
        "fov": view.fov,
        "fov_axis": "y",
        "near_clip": 1e-3,
        "to_world": mi.ScalarTransform4f().look_at(origin=view.eye, target=view.look_at, up=view.up),
        "film": film,
        "sampler": {"type": "independent"},
    }
    if view.lens_radius > 0.0:
        described |= {"type": "thinlens", "aperture_radius": view.lens_radius, "focus_distance": view.focus_distance}
    return described


def render_with_mitsuba(view, spp, seeds):
    """One picture per seed: seeds × height × width × 3."""
    with tempfile.TemporaryDirectory() as folder:
        scene = mitsuba_scene(view, folder)
        pictures = [np.array(mi.render(scene, spp=spp, seed=seed)) for seed in seeds]
    return np.stack(pictures).astype(np.float64)


# --- Tamis ------------------------------------------------------------------------------------------------------------


def render_with_tamis(tamis, view, spp, seeds):
    """One picture per seed: seeds × height × width × 3. `tamis` is the program."""
    with tempfile.TemporaryDirectory() as folder:
        path, scene = os.path.join(folder, "picture.exr"), view.scene
        if view.lights:
            scene = os.path.join(folder, "scene.toml")
            write_scene_toml(scene, view)
        return np.stack([tamis_picture(tamis, scene, view, spp, seed, path) for seed in seeds])


def write_scene_toml(path, view):
    """The geometry with the lights. Strings, numbers and lists are written alike in JSON and TOML."""
    tables = [("geometry", {"file": os.path.abspath(view.scene)}), *(("light", light) for light in view.lights)]
    with open(path, "w") as file:
        for name, table in tables:
            file.write(f"[[{name}]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items()))


def tamis_picture(tamis, scene, view, spp, seed, path):
    def joined(values):
        return ",".join(str(v) for v in values)

    command = [tamis, "render", scene, "--uniform", "--no-denoise", "--quiet", "--aov", "none"]
    command += [f"--eye={joined(view.eye)}", f"--look-at={joined(view.look_at)}", f"--up={joined(view.up)}"]
    command += [f"--fov={view.fov}", f"--size={view.size[0]}x{view.size[1]}", f"--spp={spp}"]
    command += [f"--lens-radius={view.lens_radius}", f"--focus-distance={view.focus_distance}"]
    command += [f"--max-depth={view.max_depth}", f"--seed={seed}", "-o", path]
    command += [f"--env={view.environment}"] if view.environment else []
    subprocess.run(command, check=True)
    channels = OpenEXR.File(path, separate_channels=True).channels()
    return np.stack([channels[c].pixels for c in "RGB"], axis=-1).astype(np.float64)


# --- Statistics and pictures ------------------------------------------------------------------------------------------


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
