//! Bias and variance as functions of the shared bandwidth (Moon, Carr, Yoon 2014, section 5).

/// The shared bandwidths that are tried.
pub(crate) const TRIED: [f32; 5] = [0.2, 0.4, 0.6, 0.8, 1.0];
/// No bandwidth is smaller than this.
const SMALLEST: f32 = 0.01;

/// Error of one pixel's estimate with shared bandwidth h in k dimensions: bias b₀ + b₁h², variance v₀ + v₁h⁻ᵏ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ErrorModel {
    /// k.
    pub(crate) rank: usize,
    /// b₁.
    pub(crate) bias_slope: f32,
    /// v₀.
    pub(crate) variance_floor: f32,
    /// v₁, at least 0.
    pub(crate) variance_slope: f32,
}

impl ErrorModel {
    /// Least squares through what was found at the bandwidths [`TRIED`]. A variance that grows with the bandwidth is
    /// taken for one that shrinks as fast, as in the authors' program.
    pub(crate) fn fit(rank: usize, biases: &[f32; TRIED.len()], variances: &[f32; TRIED.len()]) -> Self {
        let (_, bias_slope) = line(&TRIED.map(|h| h * h), biases);
        let (floor, slope) = line(&TRIED.map(|h| h.powi(-(rank as i32))), variances);
        let variance_floor = if slope < 0.0 { 0.0 } else { floor };
        Self { rank, bias_slope, variance_floor, variance_slope: slope.abs() }
    }

    /// The bandwidth where the squared bias (without its constant, which is mostly the pixel's own noise) and the
    /// variance sum to the least: (k v₁/(4 b₁²))^{1/(k+4)}, within the range of those tried.
    pub(crate) fn best_bandwidth(&self) -> f32 {
        let k = self.rank as f32;
        let ratio = k * self.variance_slope / (4.0 * self.bias_slope * self.bias_slope);
        if self.variance_slope == 0.0 {
            SMALLEST
        } else {
            ratio.powf(1.0 / (k + 4.0)).clamp(SMALLEST, TRIED[TRIED.len() - 1])
        }
    }

    /// Mean squared error with bandwidth `h`.
    pub(crate) fn mse(&self, h: f32) -> f32 {
        let bias = self.bias_slope * h * h;
        (self.variance_floor + self.variance_slope * h.powi(-(self.rank as i32)) + bias * bias).max(0.0)
    }
}

/// Intercept and slope of the line of least squares; slope 0 where all `x` are equal.
fn line(x: &[f32; TRIED.len()], y: &[f32; TRIED.len()]) -> (f32, f32) {
    let count = TRIED.len() as f64;
    let mean = |v: &[f32; TRIED.len()]| v.iter().map(|v| f64::from(*v)).sum::<f64>() / count;
    let (x_mean, y_mean) = (mean(x), mean(y));
    let (mut square, mut product) = (0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        square += (f64::from(*x) - x_mean).powi(2);
        product += (f64::from(*x) - x_mean) * (f64::from(*y) - y_mean);
    }
    let slope = if square > 0.0 { product / square } else { 0.0 };
    ((y_mean - slope * x_mean) as f32, slope as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_come_back_from_exact_curves() {
        let model = ErrorModel::fit(3, &TRIED.map(|h| 0.3 - 0.2 * h * h), &TRIED.map(|h| 0.01 + 0.002 * h.powi(-3)));
        assert!((model.bias_slope + 0.2).abs() < 1e-5);
        assert!((model.variance_floor - 0.01).abs() < 1e-5);
        assert!((model.variance_slope - 0.002).abs() < 1e-6);
    }

    #[test]
    fn the_best_bandwidth_has_the_least_error() {
        let model = ErrorModel { rank: 4, bias_slope: 0.5, variance_floor: 0.1, variance_slope: 0.003 };
        let best = model.best_bandwidth();
        assert!(best > 0.2 && best < 1.0);
        for i in 1..200 {
            assert!(model.mse(best) <= model.mse(i as f32 / 200.0) + 1e-7);
        }
    }

    #[test]
    fn extremes_stay_within_the_range_tried() {
        let straight = ErrorModel { rank: 2, bias_slope: 0.0, variance_floor: 0.0, variance_slope: 1.0 };
        assert_eq!(straight.best_bandwidth(), 1.0);
        let exact = ErrorModel { rank: 2, bias_slope: 1.0, ..ErrorModel::default() };
        assert_eq!(exact.best_bandwidth(), SMALLEST);
        assert_eq!(ErrorModel::fit(0, &[1.0; 5], &[1.0; 5]).variance_slope, 0.0);
    }
}
