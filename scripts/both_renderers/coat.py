"""A diffuse base under a GGX coat (crates/tracer/src/bsdf/coated.rs; Mitsuba's `plastic`, `roughplastic` and
`principled` have other bases), with albedos of its own quadrature.
"""

import math

import numpy as np

from .mitsuba_variant import dr, mi
from .trapezoid import trapezoid


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
