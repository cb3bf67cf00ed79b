//! What renderers call their layers. Data, not code: one entry a renderer, and one for names anybody may use.
//!
//! Names are compared in lower case, without separators, and without what stands in front of the last dot (a view layer).
//! Of several names for a role the first that is there counts.

use super::role::{Convention, Measure, Role};
use crate::FeatureRole::{Albedo, Depth, Normal, Position, Visibility};

/// How a renderer is recognised; one sign is enough.
#[derive(Clone, Copy, Debug)]
pub enum Sign {
    /// An attribute whose name begins with the first text, and whose value contains the second.
    Attribute(&'static str, &'static str),
    /// All of these layers.
    Layers(&'static [&'static str]),
}

/// What one renderer writes.
#[derive(Clone, Copy, Debug)]
pub struct Renderer {
    /// Its name.
    pub name: &'static str,
    /// How it is recognised.
    pub signs: &'static [Sign],
    /// Names of layers, the most specific first.
    pub means: &'static [(Role, &'static [&'static str])],
    /// What stands behind a layer's name where the layer is a measure of its noise; the first found counts.
    pub endings: &'static [(&'static str, Measure)],
    /// Layers that are a measure of a role's noise by a name of their own.
    pub noise: &'static [(Role, Measure, &'static [&'static str])],
    /// Start and end of the name of the attribute that holds the samples per pixel.
    pub spp: &'static [(&'static str, &'static str)],
    /// Names of layers that have no role here, so that a file of that name is not taken for a picture.
    pub others: &'static [&'static str],
}

const POSITION: Role = Role::Feature(Position);
const ALBEDO: Role = Role::Feature(Albedo);
const NORMAL: Role = Role::Feature(Normal);
const VISIBILITY: Role = Role::Feature(Visibility);
const DEPTH: Role = Role::Feature(Depth);

const OF_SAMPLE: Measure = Measure::Variance(Convention::Sample);
const OF_MEAN: Measure = Measure::Variance(Convention::Mean);
const UNSAID: Measure = Measure::Variance(Convention::Unsaid);
const SECOND_MOMENT: Measure = Measure::Variance(Convention::SecondMoment);
const DEVIATION: Measure = Measure::Variance(Convention::StandardError);

const NOBODY: Renderer =
    Renderer { name: "unknown", signs: &[], means: &[], endings: &[], noise: &[], spp: &[], others: &[] };

/// All renderers that are known, in the order in which their signs are looked for.
pub const RENDERERS: &[Renderer] = &[
    Renderer {
        name: "Cycles",
        signs: &[
            Sign::Attribute("BlenderMultiChannel", ""),
            Sign::Attribute("cycles.", ""),
            Sign::Layers(&["denoisingalbedo"]),
            Sign::Layers(&["noisyimage"]),
        ],
        means: &[
            // `Noisy Image` is there when Blender denoised: `Combined` is a result then.
            (Role::Colour, &["noisyimage", "combined"]),
            (POSITION, &["position"]),
            (ALBEDO, &["denoisingalbedo", "diffusecolor", "diffcol"]),
            (NORMAL, &["denoisingnormal", "normal"]),
            // Other distances than that of the first surface would not fit the position: behind a mirror, say.
            (DEPTH, &["denoisingdepth", "depth", "z"]),
            // Blender 2.79 and 2.8: how much of the light a surface would get reaches it.
            (VISIBILITY, &["denoisingshadowing"]),
            (Role::Emission, &["emission", "emit"]),
            (Role::Samples, &["debugsamplecount", "samplecount"]),
        ],
        // Written by Blender 2.79 to 2.9: (Σx² − (Σx)²/n)/n.
        endings: &[("variance", OF_SAMPLE)],
        noise: &[(Role::Colour, OF_SAMPLE, &["denoisingvariance", "denoisingimagevariance"])],
        spp: &[("cycles.", ".samples")],
        ..NOBODY
    },
    Renderer {
        name: "pbrt-v4",
        signs: &[Sign::Attribute("samplesPerPixel", ""), Sign::Layers(&["ns", "dzdx", "dzdy"])],
        means: &[(POSITION, &["p"]), (ALBEDO, &["albedo"]), (NORMAL, &["ns", "n"])],
        endings: &[("variance", OF_SAMPLE)],
        spp: &[("samplesPerPixel", "")],
        ..NOBODY
    },
    Renderer {
        name: "Mitsuba",
        signs: &[Sign::Attribute("generatedBy", "Mitsuba")],
        // Names are the user's; these are those of its documentation. What has another is told by its values.
        means: &[
            (POSITION, &["position", "pos", "pp"]),
            (ALBEDO, &["albedo", "alb"]),
            (NORMAL, &["shnormal", "nn", "shadingnormal", "sn"]),
            (DEPTH, &["depth", "dd"]),
        ],
        ..NOBODY
    },
    Renderer {
        name: "Tungsten",
        signs: &[Sign::Layers(&["colora", "colorb"]), Sign::Layers(&["color", "colorvariance"])],
        means: &[
            (Role::Colour, &["color"]),
            (ALBEDO, &["albedo"]),
            (NORMAL, &["normal"]),
            (DEPTH, &["depth"]),
            (VISIBILITY, &["visibility"]),
        ],
        endings: &[("a", Measure::HalfA), ("b", Measure::HalfB), ("variance", OF_MEAN)],
        ..NOBODY
    },
    Renderer {
        name: "LuxCore",
        signs: &[Sign::Layers(&["avgshadingnormal"]), Sign::Layers(&["rgbimagepipeline"])],
        means: &[
            (Role::Colour, &["noisy", "rgb", "rgba", "rgbimagepipeline", "rgbaimagepipeline"]),
            (POSITION, &["position"]),
            (ALBEDO, &["albedo"]),
            (NORMAL, &["avgshadingnormal", "shadingnormal", "geometrynormal"]),
            (DEPTH, &["depth"]),
            (Role::Emission, &["emission"]),
            (Role::Alpha, &["alpha"]),
            (Role::Samples, &["samplecount"]),
        ],
        others: &[
            "noise",
            "convergence",
            "materialid",
            "objectid",
            "directdiffuse",
            "directglossy",
            "indirectdiffuse",
            "indirectglossy",
            "indirectspecular",
            "directshadowmask",
            "indirectshadowmask",
            "uv",
            "raycount",
            "irradiance",
            "caustic",
            "materialidcolor",
            "userimportance",
        ],
        ..NOBODY
    },
    Renderer {
        name: "Arnold",
        signs: &[
            Sign::Attribute("arnold", ""),
            Sign::Attribute("software", "rnold"),
            Sign::Layers(&["diffusealbedonoice"]),
            Sign::Layers(&["denoisealbedonoice"]),
            Sign::Layers(&["denoisealbedo"]),
            Sign::Layers(&["variance", "diffusealbedo"]),
        ],
        means: &[
            (Role::Colour, &["rgba", "beauty"]),
            (POSITION, &["p"]),
            (ALBEDO, &["denoisealbedonoice", "denoisealbedo", "diffusealbedonoice", "diffusealbedo"]),
            (NORMAL, &["nnoice", "n"]),
            (DEPTH, &["znoice", "z"]),
            (Role::Emission, &["emission"]),
        ],
        endings: &[("variance", OF_SAMPLE)],
        // Of the filter `variance_filter`.
        noise: &[(Role::Colour, OF_SAMPLE, &["variance"])],
        ..NOBODY
    },
    Renderer {
        name: "RenderMan",
        signs: &[
            Sign::Attribute("rman", ""),
            Sign::Attribute("prman", ""),
            Sign::Attribute("software", "RenderMan"),
            Sign::Layers(&["albedomse"]),
            Sign::Layers(&["normalmse"]),
            Sign::Layers(&["zfiltered"]),
        ],
        means: &[
            (Role::Colour, &["ci"]),
            // `P` itself is in camera space.
            (POSITION, &["pworld"]),
            (ALBEDO, &["albedo"]),
            (NORMAL, &["normal", "nworld", "nn"]),
            (DEPTH, &["zfiltered", "z"]),
            (Role::Samples, &["samplecount"]),
            (Role::Alpha, &["a"]),
        ],
        // Statistics `mse` and `variance` of a display channel.
        endings: &[("mse", OF_MEAN), ("var", OF_SAMPLE), ("variance", OF_SAMPLE)],
        noise: &[(Role::Colour, OF_MEAN, &["mse"]), (Role::Colour, OF_SAMPLE, &["var", "variance"])],
        ..NOBODY
    },
    Renderer {
        name: "V-Ray",
        signs: &[
            Sign::Attribute("vrayInfo", ""),
            Sign::Layers(&["vraydiffusefilter"]),
            Sign::Layers(&["vraynormals"]),
            Sign::Layers(&["effectsresult"]),
        ],
        means: &[
            // In Maya and in files of V-Ray itself elements are called without `VRay`; `diffuse` is the reflectance there.
            (ALBEDO, &["vrayalbedo", "vraydiffusefilter", "diffusefilter", "diffuse"]),
            (NORMAL, &["vraybumpnormals", "bumpnormals", "vraynormals", "normals"]),
            (POSITION, &["vrayworldposition", "worldposition"]),
            (DEPTH, &["vrayzdepth", "zdepth", "z"]),
        ],
        ..NOBODY
    },
    Renderer {
        name: "Corona",
        signs: &[
            Sign::Attribute("corona", ""),
            Sign::Layers(&["cshadingalbedo"]),
            Sign::Layers(&["cshadingsourcecolor"]),
            Sign::Layers(&["cgeometrynormalsshading"]),
        ],
        means: &[
            (Role::Colour, &["beauty"]),
            (POSITION, &["cgeometryworldposition"]),
            (ALBEDO, &["cshadingalbedo", "cshadingsourcecolor"]),
            (NORMAL, &["cgeometrynormalsshading", "cgeometrynormalsgeometry"]),
            (DEPTH, &["cgeometryzdepth", "zdepth"]),
        ],
        ..NOBODY
    },
    Renderer {
        name: "Redshift",
        signs: &[
            Sign::Attribute("redshift", ""),
            // Octane calls it so, too.
            Sign::Layers(&["diffusefilter", "gi"]),
            Sign::Layers(&["diffusefilter", "p"]),
            Sign::Layers(&["diffusefilter", "specularlighting"]),
            Sign::Layers(&["diffusefilter", "diffuselighting"]),
        ],
        means: &[
            (POSITION, &["worldposition", "p"]),
            (ALBEDO, &["diffusefilter"]),
            (NORMAL, &["bumpnormals", "normals", "n"]),
            (DEPTH, &["z", "depth"]),
        ],
        ..NOBODY
    },
    Renderer {
        name: "BCD",
        signs: &[Sign::Layers(&["cov"]), Sign::Layers(&["hist"])],
        means: &[(Role::Colour, &["col", "color"]), (Role::Samples, &["hist"])],
        // The first three bins of the covariance are its diagonal.
        noise: &[(Role::Colour, OF_SAMPLE, &["cov"])],
        ..NOBODY
    },
    Renderer {
        name: "OIDN",
        signs: &[Sign::Layers(&["hdr"]), Sign::Layers(&["alb", "nrm"])],
        means: &[(Role::Colour, &["hdr", "ldr"]), (ALBEDO, &["alb"]), (NORMAL, &["nrm"])],
        ..NOBODY
    },
];

/// Names that anybody may use; they count where the renderer is unknown, or its own names are not there.
pub const ANYBODY: Renderer = Renderer {
    means: &[
        (Role::Colour, &["combined", "noisyimage", "noisy", "beauty", "rgba", "color", "colour", "rgb", "ci", "c"]),
        (Role::Emission, &["emission", "emissive", "emit"]),
        (POSITION, &["position", "worldposition", "pos", "p"]),
        (
            ALBEDO,
            &[
                "denoisingalbedo",
                "denoisealbedo",
                "albedo",
                "diffusealbedo",
                "diffusefilter",
                "diffusefilterinfo",
                "basecolor",
            ],
        ),
        (NORMAL, &["denoisingnormal", "avgshadingnormal", "shadingnormal", "shnormal", "ns", "normal", "normals", "n"]),
        (VISIBILITY, &["visibility"]),
        (DEPTH, &["denoisingdepth", "depth", "z", "zdepth", "hitpz", "pz"]),
        (Role::Alpha, &["alpha"]),
        (Role::Samples, &["samplecount", "debugsamplecount", "samples", "spp"]),
    ],
    endings: &[
        ("a", Measure::HalfA),
        ("b", Measure::HalfB),
        ("halfa", Measure::HalfA),
        ("halfb", Measure::HalfB),
        ("even", Measure::HalfA),
        ("odd", Measure::HalfB),
        ("variance", UNSAID),
        ("var", UNSAID),
        ("mse", OF_MEAN),
        ("standarderror", DEVIATION),
        ("stderr", DEVIATION),
        ("secondmoment", SECOND_MOMENT),
    ],
    spp: &[("samplesPerPixel", ""), ("spp", ""), ("samples", "")],
    ..NOBODY
};

/// Names that say what a layer is, but not what a file is: too many files are called so.
pub const OF_LAYERS_ALONE: &[&str] = &["a", "c", "diffuse", "basecolor"];

/// Words by which a layer is known when its whole name is not: it must contain one, and be the only one that does.
pub const WORDS: &[(Role, &[&str])] = &[
    (POSITION, &["position", "worldpos"]),
    (ALBEDO, &["albedo"]),
    (NORMAL, &["normal", "normals"]),
    (VISIBILITY, &["visibility"]),
    (DEPTH, &["depth"]),
];

/// Words that say a layer is something else, whatever else it says.
pub const OTHER_WORDS: &[&str] =
    &["denoised", "variance", "var", "mse", "stddev", "filtered", "relative", "id", "indirect", "direct", "crypto"];

/// Words of normals that are to be preferred, and of those that are not.
pub const SHADING_WORDS: &[&str] = &["shading", "sh", "ns", "bump", "smooth"];
/// As [`SHADING_WORDS`] says.
pub const GEOMETRIC_WORDS: &[&str] = &["geometric", "geometry", "geo", "ng", "face"];

/// Names of the channels of a layer of three.
pub const TRIPLES: &[[&str; 3]] = &[["R", "G", "B"], ["X", "Y", "Z"], ["Bin_0000", "Bin_0001", "Bin_0002"]];

/// Other names of channels, as Redshift writes them: `P.red`.
pub const LONG_NAMES: &[(&str, &str)] = &[("R", "red"), ("G", "green"), ("B", "blue"), ("A", "alpha")];

/// Names of the channel of a layer of one, the first that is there; none is the layer's own name.
pub const SINGLES: &[&str] = &["", "Y", "Z", "T", "V", "X", "R", "I", "A"];

/// Start of the names of BCD's histogram channels, whose last is the sample count.
pub const BIN: &str = "Bin_";

/// Depths from here on mean that nothing was hit (Blender writes 1e10).
pub const FAR_AWAY: f32 = 0.999e10;
