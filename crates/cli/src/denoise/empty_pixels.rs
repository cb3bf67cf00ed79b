//! Pixels without a trace of anything, as the stack tells by its alpha: what is not there has no light, and any that was spread
//! into it would be a fringe once the picture lies before another.

use stack::{FeatureStack, Image};

/// Those of a picture that have no alpha and are black, and of each of its passes those of them that are black there, too: the
/// sky has light of its own where the picture is empty.
pub struct EmptyPixels {
    of_picture: Vec<usize>,
    of_passes: Vec<Vec<usize>>,
}

impl EmptyPixels {
    /// Those of the noisy picture `beauty` of `stack`, and of its `passes`.
    pub fn of(stack: &FeatureStack, beauty: &Image, passes: &[Image]) -> Self {
        let alpha = stack.passthrough.iter().find(|channel| channel.name == "A");
        let clear: Vec<usize> =
            alpha.map_or_else(Vec::new, |a| (0..stack.size().pixels()).filter(|&p| a.value(p) == 0.0).collect());
        let of_picture = black_ones(&clear, beauty);
        let of_passes = passes.iter().map(|pass| black_ones(&of_picture, pass)).collect();
        Self { of_picture, of_passes }
    }

    /// Makes them black in `picture`.
    pub fn blacken(&self, picture: &mut Image) {
        blacken(picture, &self.of_picture);
    }

    /// Makes them black in the rebuilt `passes`.
    pub fn blacken_passes(&self, passes: &mut [Image]) {
        passes.iter_mut().zip(&self.of_passes).for_each(|(pass, pixels)| blacken(pass, pixels));
    }
}

/// Those of `pixels` that are black in `picture`.
fn black_ones(pixels: &[usize], picture: &Image) -> Vec<usize> {
    let is_black = |pixel: &usize| picture.channels().iter().all(|plane| plane[*pixel] == 0.0);
    pixels.iter().copied().filter(is_black).collect()
}

fn blacken(picture: &mut Image, pixels: &[usize]) {
    for plane in picture.channels_mut() {
        pixels.iter().for_each(|&pixel| plane[pixel] = 0.0);
    }
}
