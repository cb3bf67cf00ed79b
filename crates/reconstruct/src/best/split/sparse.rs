//! Where light is so sparse that most of it would be cut off: a surface that one sample in fifty sees a window from. What
//! all of it is made of is no outlier.

use rayon::prelude::*;
use stack::Size;

use super::high_ranks::NOTHING;
use crate::rectangle::{Rectangle, tiles_of};

/// Side of the blocks of pixels that light is added up over; three by three of them are looked at together.
const BLOCK: usize = 8;

/// Halvings of the range that a rise lies in, in the logarithm.
const HALVINGS: usize = 20;

/// Brightest buckets that count for nothing among three by three blocks: so few may be fireflies.
const FIREFLIES: usize = 8;

/// By how much `caps` must rise, pixel by pixel, so that no more than the share `most` of the light of a pixel's
/// surroundings is cut off, the few brightest buckets aside. `None` where that is so everywhere.
pub fn rises(size: Size, luminances: &[Vec<f32>], caps: &[f32], most: f32) -> Option<Vec<f32>> {
    let blocks = Size::new(size.width.div_ceil(BLOCK), size.height.div_ceil(BLOCK));
    let light: Vec<Light> =
        tiles_of(size, BLOCK).par_iter().map(|tile| Light::of(tile, size, luminances, caps)).collect();
    let logarithm = |block: usize| {
        let near = Rectangle::around([block % blocks.width, block / blocks.width], 1, blocks);
        let near = (near.y0..near.y1).flat_map(|y| (near.x0..near.x1).map(move |x| blocks.index(x, y)));
        rise(near.map(|block| &light[block]), most).ln()
    };
    let logarithms: Vec<f32> = (0..blocks.pixels()).into_par_iter().map(logarithm).collect();
    if logarithms.iter().all(|rise| *rise == 0.0) {
        return None;
    }
    let rise = |pixel: usize| {
        let [left, right] = between(pixel % size.width, blocks.width);
        let [above, below] = between(pixel / size.width, blocks.height);
        let row =
            |y: usize| left.1 * logarithms[blocks.index(left.0, y)] + right.1 * logarithms[blocks.index(right.0, y)];
        (above.1 * row(above.0) + below.1 * row(below.0)).exp()
    };
    Some((0..size.pixels()).into_par_iter().map(rise).collect())
}

/// The two of so many `blocks` in a row whose middles a pixel lies between, and their weights.
fn between(pixel: usize, blocks: usize) -> [(usize, f32); 2] {
    let place = ((pixel as f32 + 0.5) / BLOCK as f32 - 0.5).clamp(0.0, (blocks - 1) as f32);
    let (first, beyond) = (place as usize, place.fract());
    [(first, 1.0 - beyond), ((first + 1).min(blocks - 1), beyond)]
}

/// Light of a block.
struct Light {
    /// That of all buckets.
    sum: f64,
    /// Of those that are cut: their luminance, and what they are cut at.
    cut: Vec<[f32; 2]>,
}

impl Light {
    fn of(block: &Rectangle, size: Size, luminances: &[Vec<f32>], caps: &[f32]) -> Self {
        let mut light = Self { sum: 0.0, cut: Vec::new() };
        for y in block.y0..block.y1 {
            for plane in luminances {
                let row = size.index(block.x0, y)..size.index(block.x1, y);
                for (luminance, cap) in plane[row.clone()].iter().zip(&caps[row]).filter(|(l, _)| **l > NOTHING) {
                    light.sum += f64::from(*luminance);
                    if luminance > cap {
                        light.cut.push([*luminance, *cap]);
                    }
                }
            }
        }
        light
    }
}

/// The least factor of what these blocks are cut at by which no more than the share `most` of their light is cut off.
fn rise<'a>(blocks: impl Iterator<Item = &'a Light>, most: f32) -> f32 {
    let (mut sum, mut cut) = (0.0, Vec::new());
    for block in blocks {
        sum += block.sum;
        cut.extend_from_slice(&block.cut);
    }
    if cut.len() <= FIREFLIES {
        return 1.0;
    }
    cut.select_nth_unstable_by(FIREFLIES - 1, |a, b| b[0].total_cmp(&a[0]));
    let (brightest, cut) = cut.split_at(FIREFLIES);
    let allowed = f64::from(most) * (sum - brightest.iter().map(|[light, _]| f64::from(*light)).sum::<f64>());
    let off = |factor: f32| cut.iter().map(|[light, cap]| f64::from((light - factor * cap).max(0.0))).sum::<f64>();
    if off(1.0) <= allowed {
        return 1.0;
    }
    let largest = cut.iter().map(|[light, cap]| light / cap).fold(1.0, f32::max);
    let (mut low, mut high) = (0.0, largest.ln());
    for _ in 0..HALVINGS {
        let middle: f32 = 0.5 * (low + high);
        if off(middle.exp()) > allowed { low = middle } else { high = middle }
    }
    high.exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;

    /// Eight buckets, of which a share meets a light of 10.
    fn sparse(size: Size, share: f64) -> Vec<Vec<f32>> {
        let mut noise = TestNoise(95);
        let mut bucket = || (0..size.pixels()).map(|_| if noise.uniform() < share { 10.0 } else { 0.0 }).collect();
        (0..8).map(|_| bucket()).collect()
    }

    /// Share of the light that is cut off.
    fn share_cut(luminances: &[Vec<f32>], caps: &[f32]) -> f32 {
        let all: f32 = luminances.iter().flatten().sum();
        let off = |plane: &Vec<f32>| plane.iter().zip(caps).map(|(l, cap)| (l - cap).max(0.0)).sum::<f32>();
        luminances.iter().map(off).sum::<f32>() / all
    }

    #[test]
    fn of_sparse_light_only_a_share_is_cut_off() {
        for size in [Size::new(61, 45), Size::new(30, 30)] {
            let light = sparse(size, 0.02);
            let mut caps = vec![0.5; size.pixels()];
            assert!(share_cut(&light, &caps) > 0.9);
            let rises = rises(size, &light, &caps, 0.3).unwrap();
            caps.iter_mut().zip(rises).for_each(|(cap, rise)| *cap *= rise);
            let cut = share_cut(&light, &caps);
            assert!((0.29..0.4).contains(&cut), "and that of a few of ninety: {cut}");
        }
    }

    #[test]
    fn a_few_fireflies_and_what_is_hardly_cut_raise_nothing() {
        let size = Size::new(40, 40);
        let mut light = vec![vec![1.0; size.pixels()]; 8];
        (0..FIREFLIES).for_each(|firefly| light[firefly][17 * firefly] = 1e4);
        assert!(share_cut(&light, &vec![1.5; size.pixels()]) > 0.8);
        assert_eq!(rises(size, &light, &vec![1.5; size.pixels()], 0.3), None);
        assert_eq!(rises(size, &sparse(size, 0.02), &vec![8.0; size.pixels()], 0.3), None, "a fifth");
        assert_eq!(rises(size, &sparse(size, 0.02), &vec![0.5; size.pixels()], 1.0), None);
        assert_eq!(rises(Size::new(0, 0), &[], &[], 0.3), None);
    }
}
