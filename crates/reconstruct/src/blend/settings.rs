//! How far another picture is followed.

stack::knobs! {
    /// How far another denoiser's picture is followed.
    pub struct BlendSettings("guide") {
        /// Multiple of the weight that a guide deserves by what is known about it; 0 leaves the guide alone.
        strength: f32 = 1.0, 0.0..=1.0;
    }
}
