//! Half-buffers for a picture of which only mean and variance are known.
//!
//! From y with variance v and a random z of the same variance, A = y + z and B = y − z are uncorrelated, and each has
//! variance 2v: what two half-buffers would be (Pang et al. 2021, *Recorrupted-to-Recorrupted*; Oliveira et al. 2021,
//! *Unbiased Risk Estimation in the Normal Means Problem via Coupled Bootstrap Techniques*). Their mean is y.

use stack::Image;

/// Halves A = `mean` + z and B = `mean` − z, z normal with the given `variance` of the mean. Values may be negative: cut
/// off they would no longer average to the mean. Noise of light is mostly one of brightness, so a pixel's channels share
/// one deviate. It depends on the pixel's number alone.
pub fn recorrupted_halves(mean: &Image, variance: &Image) -> [Image; 2] {
    let mut halves = [mean.clone(), mean.clone()];
    for (half, sign) in halves.iter_mut().zip([1.0, -1.0]) {
        for (plane, variance) in half.channels_mut().iter_mut().zip(variance.channels()) {
            for (pixel, (value, v)) in plane.iter_mut().zip(variance).enumerate() {
                *value += sign * v.max(0.0).sqrt() * normal(pixel as u64);
            }
        }
    }
    halves
}

/// As [`recorrupted_halves`], but z is ± the deviation, by lot: the halves' difference tells the variance exactly.
pub fn evenly_recorrupted_halves(mean: &Image, variance: &Image) -> [Image; 2] {
    let side = |pixel: usize| if coin(pixel as u64) { 1.0 } else { -1.0 };
    [1.0, -1.0].map(|sign| {
        let mut half = mean.clone();
        for (plane, variance) in half.channels_mut().iter_mut().zip(variance.channels()) {
            for (pixel, (value, v)) in plane.iter_mut().zip(variance).enumerate() {
                *value += sign * side(pixel) * v.max(0.0).sqrt();
            }
        }
        half
    })
}

/// A standard normal number that is a function of `key`: twelve uniform ones added up, which are within ±6. Made of whole
/// numbers, so that it is the same on any machine.
fn normal(key: u64) -> f32 {
    let parts = (0..3).flat_map(|part| {
        let bits = mixed(3 * key + part);
        (0..4).map(move |i| (bits >> (16 * i)) & 0xFFFF)
    });
    let sum: u64 = parts.sum();
    // Each part is uniform on 0 … 65535: mean 32767.5, variance (2³² − 1)/12.
    (sum as f32 - 12.0 * 32767.5) / 65536.0
}

/// Number `key` of the sequence SplitMix64 (Steele et al. 2014).
fn mixed(key: u64) -> u64 {
    let mut z = key.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// One random bit that is a function of `key`, independent of the halves' deviates.
pub fn coin(key: u64) -> bool {
    mixed(key ^ (1 << 63)) & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;
    use stack::Size;

    const SIZE: Size = Size::new(100, 100);

    fn moment(a: &[f32], b: &[f32]) -> f32 {
        a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>() / a.len() as f32
    }

    #[test]
    fn halves_are_uncorrelated_with_twice_the_variance_and_average_to_the_mean() {
        let mut noise = TestNoise(7);
        let planes: Vec<Vec<f32>> = (0..3).map(|_| noise.normals(SIZE.pixels(), 0.0, 0.5)).collect();
        let mean = Image::from_channels(SIZE, planes);
        let variance = Image::from_channels(SIZE, vec![vec![0.25; SIZE.pixels()]; 3]);
        let [a, b] = recorrupted_halves(&mean, &variance);
        for c in 0..3 {
            let [a, b, y] = [&a, &b, &mean].map(|image| &image.channels()[c]);
            assert!((moment(a, a) / 0.5 - 1.0).abs() < 0.05 && (moment(b, b) / 0.5 - 1.0).abs() < 0.05);
            assert!(moment(a, b).abs() < 0.02, "{}", moment(a, b));
            assert!(a.iter().zip(b).zip(y).all(|((a, b), y)| (0.5 * (a + b) - y).abs() < 1e-6));
        }
    }

    #[test]
    fn deviates_are_normal_and_do_not_repeat() {
        let deviates: Vec<f32> = (0..20_000).map(normal).collect();
        let [mean, square] = [1, 2].map(|p| deviates.iter().map(|z| z.powi(p)).sum::<f32>() / 20_000.0);
        let fourth = deviates.iter().map(|z| z.powi(4)).sum::<f32>() / 20_000.0;
        assert!(
            mean.abs() < 0.03 && (square - 1.0).abs() < 0.04 && (fourth - 2.9).abs() < 0.2,
            "{mean} {square} {fourth}"
        );
        assert!(moment(&deviates[1..], &deviates[..19_999]).abs() < 0.03);
        let heads = (0..20_000).filter(|key| coin(*key)).count();
        assert!((9_700..10_300).contains(&heads), "{heads}");
    }
}
