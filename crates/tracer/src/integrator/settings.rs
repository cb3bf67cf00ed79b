//! Settings of the path tracer.

stack::knob_choice! {
    /// Where along a path features are recorded.
    pub enum FeatureHit {
        /// At the first surface that is neither a perfect mirror nor clear glass: what one sees in the mirror.
        FirstNonSpecular = "first-non-specular",
        /// At the first surface, as in the paper.
        First = "first",
    }
}

stack::knob_choice! {
    /// How light that arrives at a surface directly from a lamp or the sky is found.
    pub enum DirectLight {
        /// By sampling lights and by sampling the surface, combined (multiple importance sampling).
        Both = "both",
        /// By sampling lights only; perfect mirrors and glass still find them by themselves.
        Lights = "lights",
        /// By sampling the surface only; point lights, spots and suns are not found.
        Surfaces = "surfaces",
    }
}

stack::knobs! {
    /// How paths are traced and their samples gathered.
    pub struct TraceSettings("") {
        /// Longest path, in scattering events: 0 shows emission only, 1 adds direct light
        /// (Mitsuba's `max_depth` minus one). Light on longer paths is missing from the picture.
        max_depth: u32 = 32, 0..=4096;
        /// Scattering events after which Russian roulette begins to end dim paths. It changes noise and time, not the
        /// mean: a path goes on with probability max(0.05, min(1, its largest throughput)). Not below `max-depth` is off.
        roulette_depth: u32 = 4, 0..=4096;
        /// Where along a path features are recorded.
        feature_hit: FeatureHit = FeatureHit::FirstNonSpecular, ..;
        /// How light that comes directly from a lamp or the sky is found. Changes noise, not the mean.
        direct_light: DirectLight = DirectLight::Both, ..;
        /// Photons sent for every sample of a pixel to what mirrors and refracts, from lamps and the sky. They show caustics
        /// in the light that is gathered. Nothing else depends on them; 0 sends none.
        photons: f32 = 0.125, 0.0..=64.0;
        /// Independently scrambled sequences that a pixel's samples are dealt to. More make the buckets' spread a truer
        /// measure of noise; fewer make less noise. Must divide `buckets`.
        sequences: u32 = 8, 1..=64;
        /// Partial means kept of each pixel's radiance.
        buckets: u32 = 8, 1..=64;
        /// Seed of all random numbers. The same seed gives the same picture, bit for bit.
        seed: u64 = 0, ..;
    }
}
