#!/usr/bin/env python3
"""Renders one OBJ scene with Tamis and with Mitsuba 3, and tells whether the pictures differ by more than noise.

    pip install mitsuba numpy openexr pillow          (tried with mitsuba 3.9, numpy 2, openexr 3.5, pillow 13)
    python scripts/compare_with_mitsuba.py SCENE.obj --eye 0,1,5 --look-at 0,1,0 --fov 30 -o DIR

Geometry, materials and camera are read and built here, from the OBJ and MTL files and from what Tamis documents; no
code is shared with it. Both render `--seeds` pictures of `--spp` samples with as many independent seeds, from whose
spread the standard errors follow. Printed are the means per channel with their ratio, and how far the means over
blocks of 16 × 16 pixels lie apart in units of their standard error. DIR gets both pictures side by side with their
difference. The exit status is 1 when a ratio is off by more than `--tolerance` and by more than 3 standard errors.

Mitsuba needs a libLLVM of version 17 or later (older ones stop with "Cannot select … fminimum"). Unless
DRJIT_LIBLLVM_PATH names one, the one in the Rust toolchain is taken.

Tamis's diffuse base under a GGX coat has no equal in Mitsuba (`plastic`, `roughplastic` and `principled` have other
bases): `Coat` below is its documented formula, with albedos of its own quadrature. Tamis's metals are that coat over
nothing. Diffuse, mirror and glass are Mitsuba's own. Known to differ: Tamis sees the geometric normal where a viewer
is below the shading horizon, Mitsuba turns the shading normal round, which shows at silhouettes of coarse meshes; and
Tamis's coats look albedos up in a table that is right to 0.002. Textures are not supported.

Errors come from few seeds, and caustics' noise has long tails: look at a deviating block again with other seeds
(`--first-seed`) before believing it.
"""

import argparse
import dataclasses
import glob
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

BLOCK = 16


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
    """Triangles of one material, each of three (position, normal) pairs of indices; normal is None without any."""

    material: str
    triangles: list = dataclasses.field(default_factory=list)


def read_obj(path):
    """Positions, normals, parts and materials of an OBJ file."""
    positions, normals, parts, materials, material = [], [], {}, {}, ""
    for key, words in statements(path):
        if key == "v":
            positions.append([float(w) for w in words[:3]])
        elif key == "vn":
            normals.append([float(w) for w in words[:3]])
        elif key == "mtllib":
            materials |= read_mtl(os.path.join(os.path.dirname(path), " ".join(words)))
        elif key == "usemtl":
            material = " ".join(words)
        elif key == "f":
            corners = [corner(word, len(positions), len(normals)) for word in words]
            smooth = all(normal is not None for _, normal in corners)
            part = parts.setdefault((material, smooth), Part(material))
            fan = zip(corners[1:], corners[2:])
            part.triangles += [(corners[0], b, c) for b, c in fan]
    return np.array(positions), np.array(normals), list(parts.values()), materials


def corner(word, positions, normals):
    """Zero-based indices of position and normal of a face's corner; negative ones count from the end."""
    fields = [int(f) if f else 0 for f in word.split("/")] + [0, 0]
    absolute = [i - 1 if i > 0 else i + n for i, n in ((fields[0], positions), (fields[2], normals))]
    return absolute[0], absolute[1] if fields[2] else None


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


def bsdf(name, entry):
    """Mitsuba's description of a material."""
    unsupported = [key for key in ("map_kd", "map_ks", "map_ke") if key in entry]
    if unsupported:
        sys.exit(f"material '{name}': textures ({', '.join(unsupported)}) cannot be compared")
    model, alpha = number(entry, "illum"), roughness(entry)
    diffuse, specular = reflectances(entry)
    opacity = number(entry, "d", 1.0 - number(entry, "tr", 0.0))
    if number(entry, "pm", 0.0) >= 1.0:
        return metal(diffuse if diffuse.any() else specular, alpha)
    if model == 5:
        return mirror(specular if specular.any() else diffuse)
    if model in (4, 6, 7, 9) or (opacity < 1.0 and "ni" in entry):
        return glass(entry)
    if model in (3, 8) and specular.any() and not diffuse.any():
        return metal(specular, alpha)
    return opaque(entry, diffuse, specular, alpha)


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
    """Rough metal is the coat over nothing; a smooth one is a mirror."""
    if alpha is None or alpha < 0.01:
        return mirror(reflectance)
    return coat(np.zeros(3), np.minimum(reflectance, 1.0), alpha)


def mirror(reflectance):
    perfect = {"type": "conductor", "material": "none", "specular_reflectance": rgb(np.minimum(reflectance, 1.0))}
    return {"type": "twosided", "bsdf": perfect}


def glass(entry):
    tint = rgb(np.minimum(numbers(entry, "tf", np.ones(3)), 1.0))
    ior = number(entry, "ni", 1.5)
    return {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0, "specular_transmittance": tint}


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


class AlbedoTable:
    """E(cos) of a coat, per channel, at even places of cos^¼; and its cosine-weighted mean."""

    PLACES = 128

    def __init__(self, specular, alpha):
        places = np.linspace(0.0, 1.0, self.PLACES)
        perfect, grazing = np.array([split_albedo(max(p, 1e-2) ** 4, alpha) for p in places]).T
        albedos = [f0 * perfect + (1.0 - f0) * grazing for f0 in specular]
        fine = np.linspace(0.0, 1.0, 20001)
        means = [np.trapezoid(np.interp(fine, places, e) * 8.0 * fine**7, fine) for e in albedos]
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


# --- Mitsuba ---------------------------------------------------------------------------------------------------------


def write_ply(path, part, positions, normals):
    """The part as a PLY file; whether it has normals."""
    corners = [c for triangle in part.triangles for c in triangle]
    unique = {c: i for i, c in enumerate(dict.fromkeys(corners))}
    smooth = corners[0][1] is not None
    mesh = mi.Mesh("part", len(unique), len(part.triangles), has_vertex_normals=smooth)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = positions[[p for p, _ in unique]].astype(np.float32).ravel()
    if smooth:
        of_vertices = normals[[n for _, n in unique]]
        of_vertices /= np.linalg.norm(of_vertices, axis=1, keepdims=True)
        parameters["vertex_normals"] = of_vertices.astype(np.float32).ravel()
    parameters["faces"] = np.array([unique[c] for c in corners], dtype=np.uint32)
    parameters.update()
    mesh.write_ply(path)
    return smooth


def shape(path, part, positions, normals, entry):
    """A part as Mitsuba's shape. Lamps emit around the geometric normal in Tamis, so they get no others here."""
    smooth = write_ply(path, part, positions, normals)
    emission = numbers(entry, "ke", np.zeros(3))
    described = {"type": "ply", "filename": path, "face_normals": not smooth or bool(emission.any())}
    described["bsdf"] = bsdf(part.material, entry)
    if emission.any():
        described["emitter"] = {"type": "area", "radiance": rgb(emission)}
    return described


def mitsuba_scene(options, folder):
    positions, normals, parts, materials = read_obj(options.scene)
    described = {"type": "scene", "sensor": sensor(options)}
    described["integrator"] = {"type": "path", "max_depth": options.max_depth + 1, "rr_depth": 100000}
    for i, part in enumerate(parts):
        path = os.path.join(folder, f"part{i}.ply")
        described[f"part{i}"] = shape(path, part, positions, normals, materials.get(part.material, {}))
    return mi.load_dict(described)


def sensor(options):
    width, height = options.size
    view = mi.ScalarTransform4f().look_at(origin=options.eye, target=options.look_at, up=options.up)
    film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "component_format": "float32"}
    film["rfilter"] = {"type": "box"}
    return {
        "type": "perspective",
        "fov": options.fov,
        "fov_axis": "y",
        "near_clip": 1e-3,
        "to_world": view,
        "film": film,
        "sampler": {"type": "independent"},
    }


def render_with_mitsuba(options):
    """One picture per seed: seeds × height × width × 3."""
    with tempfile.TemporaryDirectory() as folder:
        scene = mitsuba_scene(options, folder)
        pictures = [np.array(mi.render(scene, spp=options.spp, seed=seed)) for seed in seeds_of(options)]
    return np.stack(pictures).astype(np.float64)


# --- Tamis -----------------------------------------------------------------------------------------------------------


def render_with_tamis(options):
    """One picture per seed: seeds × height × width × 3."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "picture.exr")
        return np.stack([tamis_picture(options, seed, path) for seed in seeds_of(options)])


def tamis_picture(options, seed, path):
    def joined(values):
        return ",".join(str(v) for v in values)

    command = [options.tamis, "render", options.scene, "--uniform", "--no-denoise", "--quiet", "--aov", "none"]
    command += [f"--eye={joined(options.eye)}", f"--look-at={joined(options.look_at)}", f"--up={joined(options.up)}"]
    command += [f"--fov={options.fov}", f"--size={options.size[0]}x{options.size[1]}", f"--spp={options.spp}"]
    command += [f"--max-depth={options.max_depth}", f"--seed={seed}", "-o", path]
    subprocess.run(command, check=True)
    channels = OpenEXR.File(path, separate_channels=True).channels()
    return np.stack([channels[c].pixels for c in "RGB"], axis=-1).astype(np.float64)


# --- Statistics ------------------------------------------------------------------------------------------------------


def mean_and_error(samples):
    """Mean over the first axis, and its standard error."""
    return samples.mean(axis=0), samples.std(axis=0, ddof=1) / math.sqrt(len(samples))


def block_means(pictures):
    """Means over blocks of 16 × 16 pixels; what is left at the right and the bottom is not looked at."""
    seeds, height, width, _ = pictures.shape
    rows, columns = height // BLOCK, width // BLOCK
    cut = pictures[:, : rows * BLOCK, : columns * BLOCK]
    return cut.reshape(seeds, rows, BLOCK, columns, BLOCK, 3).mean(axis=(2, 4))


def student_tail(limit, freedom):
    """Share of Student's t that lies beyond ± limit: errors estimated from few seeds have longer tails than noise."""
    t = np.linspace(-limit, limit, 20001)
    norm = math.exp(math.lgamma((freedom + 1) / 2) - math.lgamma(freedom / 2)) / math.sqrt(freedom * math.pi)
    return 1.0 - norm * np.trapezoid((1.0 + t * t / freedom) ** (-(freedom + 1) / 2), t)


def report_means(tamis, mitsuba, tolerance):
    """Prints the means; whether they agree."""
    agrees = True
    print("channel       Tamis  std.err     Mitsuba  std.err       ratio  std.err")
    for channel, name in enumerate("RGB"):
        (a, ea), (b, eb) = (mean_and_error(p[..., channel].mean(axis=(1, 2))) for p in (tamis, mitsuba))
        ratio, error = a / b, a / b * math.hypot(ea / a, eb / b)
        print(f"{name:7} {a:11.6f} {ea:8.6f} {b:11.6f} {eb:8.6f} {ratio:11.5f} {error:8.5f}")
        agrees &= abs(ratio - 1.0) <= max(tolerance, 3.0 * error)
    return agrees


def report_blocks(tamis, mitsuba):
    (a, ea), (b, eb) = mean_and_error(block_means(tamis)), mean_and_error(block_means(mitsuba))
    error = np.hypot(ea, eb)
    deviation = np.divide(a - b, error, out=np.where(a == b, 0.0, np.inf), where=error > 0.0)
    row, column, channel = np.unravel_index(np.abs(deviation).argmax(), deviation.shape)
    beyond, tail = (np.abs(deviation) > 3.0).mean(), student_tail(3.0, 2 * (len(tamis) - 1))
    print(f"\nblocks of {BLOCK}x{BLOCK} pixels, each channel: {deviation.size}")
    print(
        f"largest deviation: {deviation[row, column, channel]:+.2f} standard errors ({'RGB'[channel]} of block "
        f"{column},{row}: {a[row, column, channel]:.6f} and {b[row, column, channel]:.6f})"
    )
    print(f"root mean square deviation: {np.sqrt((deviation**2).mean()):.2f} standard errors")
    print(f"beyond 3 standard errors: {100 * beyond:.2f} % (by chance {100 * tail:.2f} %)")


# --- Pictures --------------------------------------------------------------------------------------------------------


def write_side_by_side(path, tamis, mitsuba):
    """Tamis, Mitsuba, and 0.5 + ten times their difference."""
    gap = np.ones((tamis.shape[0], 4, 3))
    shown = [displayed(tamis), gap, displayed(mitsuba), gap, 0.5 + 10.0 * (displayed(tamis) - displayed(mitsuba))]
    Image.fromarray((np.clip(np.hstack(shown), 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)).save(path)


def displayed(picture):
    clipped = np.clip(picture, 0.0, 1.0)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1.0 / 2.4) - 0.055)


# --- Command line ----------------------------------------------------------------------------------------------------


def seeds_of(options):
    return range(options.first_seed, options.first_seed + options.seeds)


def parse_options():
    def triple(text):
        return [float(v) for v in text.split(",")]

    def size(text):
        return [int(v) for v in text.split("x")]

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--eye", type=triple, required=True)
    parser.add_argument("--look-at", type=triple, required=True)
    parser.add_argument("--up", type=triple, default=[0.0, 1.0, 0.0])
    parser.add_argument("--fov", type=float, default=45.0, help="vertical, in degrees")
    parser.add_argument("--size", type=size, default=[128, 128])
    parser.add_argument("--spp", type=int, default=32, help="of each seed")
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--first-seed", type=int, default=0, help="other seeds, another verdict")
    parser.add_argument("--max-depth", type=int, default=8, help="scattering events, as Tamis counts them")
    parser.add_argument("--tolerance", type=float, default=0.01)
    parser.add_argument("--tamis", default="target/debug/tamis")
    parser.add_argument("-o", "--output", default=".", help="folder of the pictures")
    return parser.parse_args()


def main():
    options = parse_options()
    tamis = render_with_tamis(options)
    mitsuba = render_with_mitsuba(options)
    agrees = report_means(tamis, mitsuba, options.tolerance)
    report_blocks(tamis, mitsuba)
    os.makedirs(options.output, exist_ok=True)
    name = os.path.splitext(os.path.basename(options.scene))[0]
    write_side_by_side(os.path.join(options.output, f"{name}.png"), tamis.mean(axis=0), mitsuba.mean(axis=0))
    sys.exit(0 if agrees else 1)


if __name__ == "__main__":
    main()
