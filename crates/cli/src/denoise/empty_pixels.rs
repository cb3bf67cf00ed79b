//! Pixels without a trace of anything, as the stack tells by its alpha: what is not there has no light, and any that was spread
//! into it would be a fringe once the picture lies before another.

use stack::{FeatureStack, Image};

/// Those of a picture that have no alpha and are black. A pass is rebuilt with the weights of the picture, which has none to
/// give there, so it keeps what it had: nothing, or light of its own, as a sky has behind a picture without one.
pub struct EmptyPixels {
    pixels: Vec<usize>,
    of_passes: Vec<Kept>,
}

/// What a pass had in the empty pixels; nothing where it was black in all of them.
struct Kept {
    values: Vec<[f32; 3]>,
    lit: usize,
}

impl EmptyPixels {
    /// Those of the noisy picture `beauty` of `stack`, and what its `passes` have there.
    pub fn of(stack: &FeatureStack, beauty: &Image, passes: &[Image]) -> Self {
        let alpha = stack.passthrough.iter().find(|channel| channel.name == "A");
        let pixels: Vec<usize> = alpha.map_or_else(Vec::new, |alpha| {
            (0..stack.size().pixels()).filter(|&p| alpha.value(p) == 0.0 && is_black(&beauty.rgb(p))).collect()
        });
        let of_passes = passes.iter().map(|pass| Kept::of(pass, &pixels)).collect();
        Self { pixels, of_passes }
    }

    /// Makes them black in `picture`.
    pub fn blacken(&self, picture: &mut Image) {
        self.put(picture, &[]);
    }

    /// Gives the rebuilt `passes` what they had there; in how many pixels each has light.
    pub fn restore_passes(&self, passes: &mut [Image]) -> Vec<usize> {
        passes.iter_mut().zip(&self.of_passes).for_each(|(pass, kept)| self.put(pass, &kept.values));
        self.of_passes.iter().map(|kept| kept.lit).collect()
    }

    /// Puts `values` there, or black where there are none.
    fn put(&self, picture: &mut Image, values: &[[f32; 3]]) {
        for (c, plane) in picture.channels_mut().iter_mut().enumerate() {
            for (i, &pixel) in self.pixels.iter().enumerate() {
                plane[pixel] = values.get(i).map_or(0.0, |value| value[c]);
            }
        }
    }
}

impl Kept {
    fn of(pass: &Image, pixels: &[usize]) -> Self {
        let lit = pixels.iter().filter(|pixel| !is_black(&pass.rgb(**pixel))).count();
        let values = if lit > 0 { pixels.iter().map(|pixel| pass.rgb(*pixel)).collect() } else { Vec::new() };
        Self { values, lit }
    }
}

fn is_black(values: &[f32; 3]) -> bool {
    values.iter().all(|value| *value == 0.0)
}
