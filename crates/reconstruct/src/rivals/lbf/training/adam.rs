//! Steps along a noisy gradient (Kingma, Ba 2015: *Adam: A Method for Stochastic Optimization*, algorithm 1).

/// How fast the mean gradient is forgotten.
const BETA_1: f64 = 0.9;
/// How fast the mean squared gradient is forgotten.
const BETA_2: f64 = 0.999;
/// Keeps steps finite where there is no gradient.
const EPSILON: f64 = 1e-8;

/// Moving means of gradients.
#[derive(Clone, Debug)]
pub(super) struct Adam {
    means: Vec<f64>,
    squares: Vec<f64>,
    steps: i32,
}

impl Adam {
    pub(super) fn new(parameters: usize) -> Self {
        Self { means: vec![0.0; parameters], squares: vec![0.0; parameters], steps: 0 }
    }

    /// Steps made so far.
    pub(super) const fn steps(&self) -> i32 {
        self.steps
    }

    /// Moves `parameters` against their `gradient`, each by about `rate`.
    pub(super) fn step(&mut self, parameters: &mut [f32], gradient: &[f64], rate: f64) {
        self.steps += 1;
        let (unbias_1, unbias_2) = (1.0 - BETA_1.powi(self.steps), 1.0 - BETA_2.powi(self.steps));
        for (i, g) in gradient.iter().enumerate() {
            self.means[i] = BETA_1 * self.means[i] + (1.0 - BETA_1) * g;
            self.squares[i] = BETA_2 * self.squares[i] + (1.0 - BETA_2) * g * g;
            let step = self.means[i] / unbias_1 / ((self.squares[i] / unbias_2).sqrt() + EPSILON);
            parameters[i] -= (rate * step) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_has_the_length_of_the_rate_whatever_the_gradient() {
        let (mut adam, mut parameters) = (Adam::new(3), vec![0.0; 3]);
        adam.step(&mut parameters, &[1e-3, -500.0, 0.0], 0.1);
        assert!((parameters[0] + 0.1).abs() < 1e-5 && (parameters[1] - 0.1).abs() < 1e-5);
        assert_eq!(parameters[2], 0.0);
    }

    #[test]
    fn a_bowl_is_descended_to_its_bottom() {
        let (mut adam, mut parameters) = (Adam::new(2), vec![3.0, -2.0]);
        for step in 0..400 {
            let gradient = [2.0 * f64::from(parameters[0] - 1.0), 200.0 * f64::from(parameters[1] - 0.5)];
            adam.step(&mut parameters, &gradient, 0.1 * (1.0 - f64::from(step) / 400.0));
        }
        assert!((parameters[0] - 1.0).abs() < 1e-2 && (parameters[1] - 0.5).abs() < 1e-2, "{parameters:?}");
    }
}
