//! Figures of an error map set against true errors.

use stack::Image;

/// Parts of equally many pixels that brightness is divided into.
const PARTS: usize = 10;

/// Share of the mean error below which a decile holds none worth estimating: black background, for one.
const NEGLIGIBLE: f64 = 1e-4;

/// A picture with its own estimate of its error, and what the truth is.
pub struct Judged<'a> {
    pub picture: &'a Image,
    /// Estimated squared error, mean over RGB.
    pub mse: &'a [f32],
    /// Variance of the noisy picture, mean over RGB: the ranking to beat.
    pub raw_variance: &'a [f32],
    /// Two references of independent noise: the product of the errors against them is the true squared error on average.
    pub references: &'a [Image; 2],
}

/// How an estimate compares with the truth. Errors are relative to the picture's mean true error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    /// Mean estimate by decile of brightness, darkest first.
    pub estimated: [f64; PARTS],
    /// Mean true error there.
    pub truth: [f64; PARTS],
    /// Mean estimate and mean truth without the 0.1 % of pixels of the largest true error, in which chance decides.
    pub trimmed: [f64; 2],
    /// Area between the sparsification curve and the oracle's, with the estimate's order and the raw variance's.
    pub areas: [f64; 2],
    /// The same for errors relative to the squared brightness + 0.001.
    pub relative_areas: [f64; 2],
}

impl Calibration {
    /// Mean estimate over mean truth.
    pub fn ratio(&self) -> f64 {
        self.estimated.iter().sum::<f64>() / self.truth.iter().sum::<f64>()
    }

    /// The same in each decile; `None` where there is next to no error.
    pub fn ratios(&self) -> [Option<f64>; PARTS] {
        std::array::from_fn(|part| (self.truth[part] > NEGLIGIBLE).then(|| self.estimated[part] / self.truth[part]))
    }

    /// Means over pictures, each of which counts the same.
    pub fn pooled<'a>(all: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let count = all.clone().count().max(1) as f64;
        let mut mean = Self::default();
        for one in all {
            for part in 0..PARTS {
                mean.estimated[part] += one.estimated[part] / count;
                mean.truth[part] += one.truth[part] / count;
            }
            for i in 0..2 {
                mean.trimmed[i] += one.trimmed[i] / count;
                mean.areas[i] += one.areas[i] / count;
                mean.relative_areas[i] += one.relative_areas[i] / count;
            }
        }
        mean
    }
}

/// Sets the estimate beside the truth.
pub fn calibrate(judged: &Judged) -> Calibration {
    let truth = true_errors(judged);
    let mean = average(&truth);
    let brightness: Vec<f64> = (0..truth.len())
        .map(|pixel| judged.references.iter().map(|reference| f64::from(reference.mean_at(pixel))).sum::<f64>() / 2.0)
        .collect();
    let order = ascending(&brightness);
    let estimate: Vec<f64> = judged.mse.iter().map(|v| f64::from(*v)).collect();
    let raw: Vec<f64> = judged.raw_variance.iter().map(|v| f64::from(*v)).collect();
    let kept = &ascending(&truth)[..truth.len() - truth.len().div_ceil(1000)];
    let trimmed = [&estimate, &truth].map(|values| kept.iter().map(|pixel| values[*pixel]).sum::<f64>() / mean);
    let relative =
        |values: &[f64]| -> Vec<f64> { values.iter().zip(&brightness).map(|(v, b)| v / (b * b + 1e-3)).collect() };
    Calibration {
        estimated: by_part(&estimate, &order).map(|v| v / mean),
        truth: by_part(&truth, &order).map(|v| v / mean),
        trimmed,
        areas: [&estimate, &raw].map(|by| area_to_oracle(&truth, by)),
        relative_areas: [&estimate, &raw].map(|by| area_to_oracle(&relative(&truth), &relative(by))),
    }
}

/// (x − r₁)(x − r₂), mean over RGB.
fn true_errors(judged: &Judged) -> Vec<f64> {
    let [first, second] = judged.references;
    let error = |pixel: usize| {
        let (x, r, s) = (judged.picture.rgb(pixel), first.rgb(pixel), second.rgb(pixel));
        (0..3).map(|c| f64::from(x[c] - r[c]) * f64::from(x[c] - s[c])).sum::<f64>() / 3.0
    };
    (0..judged.picture.pixels()).map(error).collect()
}

fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn ascending(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    order
}

/// Means over equal parts of the pixels in `order`.
fn by_part(values: &[f64], order: &[usize]) -> [f64; PARTS] {
    let edge = |part: usize| part * order.len() / PARTS;
    std::array::from_fn(|part| {
        average(&order[edge(part)..edge(part + 1)].iter().map(|pixel| values[*pixel]).collect::<Vec<_>>())
    })
}

/// Area between the sparsification curves in the order of `by` and in the best order, of the mean error.
fn area_to_oracle(errors: &[f64], by: &[f64]) -> f64 {
    (area(errors, by) - area(errors, errors)) / average(errors)
}

/// Area under the sparsification curve: the mean error of the pixels that are left, averaged over how many were removed,
/// largest `by` first (Ilg et al. 2018).
fn area(errors: &[f64], by: &[f64]) -> f64 {
    let mut sum = 0.0;
    let means = ascending(by).into_iter().enumerate().map(|(left, pixel)| {
        sum += errors[pixel];
        sum / (left + 1) as f64
    });
    average(&means.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use stack::Size;

    #[test]
    fn an_honest_map_has_ratios_of_one_and_no_area() {
        let size = Size::new(10, 10);
        let brightness: Vec<f32> = (0..100).map(|i| 1.0 + i as f32).collect();
        let error: Vec<f32> = (0..100).map(|i| 0.1 * (1 + i * 37 % 100) as f32).collect();
        let picture = brightness.iter().zip(&error).map(|(b, e)| b + e).collect::<Vec<_>>();
        let image = |plane: &[f32]| Image::from_channels(size, vec![plane.to_vec(); 3]);
        let references = [image(&brightness), image(&brightness)];
        let squares: Vec<f32> = error.iter().map(|e| e * e).collect();
        let reversed: Vec<f32> = squares.iter().map(|e| -e).collect();
        let judged =
            Judged { picture: &image(&picture), mse: &squares, raw_variance: &reversed, references: &references };
        let found = calibrate(&judged);
        assert!(found.ratios().iter().flatten().all(|ratio| (ratio - 1.0).abs() < 1e-4), "{found:?}");
        assert!(found.areas[0].abs() < 1e-4, "{found:?}");
        // Errors 1 … n squared, largest kept longest: the means are those of the largest k.
        let from = |k: i32| (101 - k..=100).map(|i| f64::from(i * i)).sum::<f64>() / f64::from(k);
        let to = |k: i32| (1..=k).map(|i| f64::from(i * i)).sum::<f64>() / f64::from(k);
        let expected = (1..=100).map(|k| from(k) - to(k)).sum::<f64>() / 100.0 / from(100);
        assert!((found.areas[1] - expected).abs() < 1e-3, "{} {expected}", found.areas[1]);
        let twice: Vec<f32> = squares.iter().map(|e| 2.0 * e).collect();
        assert!((calibrate(&Judged { mse: &twice, ..judged }).ratio() - 2.0).abs() < 1e-4);
    }
}
