"""Light that facets scatter more than once (crates/tracer/src/bsdf/conductor.rs, rough_glass.rs). The albedos for it are
those of Mitsuba's own sampling.
"""

import numpy as np

from .colours import rgb
from .mitsuba_variant import dr, mi


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
