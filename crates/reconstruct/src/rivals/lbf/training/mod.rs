//! Training: the network's weights, through the filter, by the error of the filtered picture (the paper's section 4.1).

mod example;
mod fixed;
mod gradient;

use stack::{Cancelled, Monitor};

use super::kernel::{Bandwidths, TERMS};
use super::network::{HIDDEN, Network, PARAMETERS, output_of_unit};
use super::secondary::{INPUTS, Inputs};
use crate::network::{Adam, Numbers};
pub use example::Example;
pub use fixed::best_fixed;
use gradient::Batch;

/// How the network is trained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingSettings {
    /// Radius of the filter's window.
    pub radius: usize,
    /// How often every pixel is seen.
    pub epochs: usize,
    /// Rows whose gradient makes one step.
    pub rows: usize,
    /// Length of the first step; it falls to 0 along a half cosine.
    pub rate: f64,
    /// Share by which weights shrink per unit of step length.
    pub decay: f64,
    /// Seed of the first weights and of the order of rows.
    pub seed: u64,
}

/// Trains a network that begins as the filter of fixed `bandwidths`. The result depends on nothing but the arguments.
/// Reports one unit per epoch as stage `training`, and notes the mean error of each.
///
/// # Errors
/// When `monitor` cancels.
pub fn train(
    examples: &[Example],
    bandwidths: Bandwidths,
    settings: &TrainingSettings,
    monitor: &dyn Monitor,
) -> Result<Network, Cancelled> {
    let mut network = start(examples.iter().flat_map(|example| &example.inputs), bandwidths, settings.seed);
    let mut rows: Vec<(usize, usize)> = rows_of(examples, 1);
    let mut numbers = Numbers::new(settings.seed);
    let mut adam = Adam::new(PARAMETERS);
    let steps = (settings.epochs * rows.len().div_ceil(settings.rows)) as f64;
    monitor.begin("training", settings.epochs as u64);
    for epoch in 0..settings.epochs {
        numbers.shuffle(&mut rows);
        let mut errors = Vec::new();
        for batch in rows.chunks(settings.rows) {
            let slope = Batch { examples, rows: batch, radius: settings.radius }.slope(&network, monitor)?;
            errors.push(slope.error);
            let rate = settings.rate * 0.5 * (1.0 + (std::f64::consts::PI * adam.steps() as f64 / steps).cos());
            shrink(&mut network.parameters, rate * settings.decay);
            adam.step(&mut network.parameters, &slope.gradient, rate);
        }
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        monitor.note(&format!("epoch {}: error {mean:.5}", epoch + 1));
        monitor.advance(1);
    }
    Ok(network)
}

/// A network whose outputs are `bandwidths` whatever its inputs; their means and deviations are those of `inputs`.
pub(super) fn start<'a>(
    inputs: impl Iterator<Item = &'a Inputs> + Clone,
    bandwidths: Bandwidths,
    seed: u64,
) -> Network {
    let count = inputs.clone().count().max(1) as f64;
    let mean = |value: &dyn Fn(&Inputs) -> f64| inputs.clone().map(value).sum::<f64>() / count;
    let means: [f64; INPUTS] = std::array::from_fn(|i| mean(&|inputs| f64::from(inputs[i])));
    let variances: [f64; INPUTS] = std::array::from_fn(|i| mean(&|inputs| (f64::from(inputs[i]) - means[i]).powi(2)));
    // An input that never varied says nothing; when it does later, it should not shout.
    let deviations = variances.map(|variance| if variance > 1e-6 { variance.sqrt() as f32 } else { 1.0 });
    let mut numbers = Numbers::new(!seed);
    let scale = 1.0 / (INPUTS as f64).sqrt();
    let mut parameters: Vec<f32> = (0..HIDDEN * (INPUTS + 1)).map(|_| (scale * numbers.symmetric()) as f32).collect();
    for _ in 0..TERMS {
        parameters.push(output_of_unit());
        parameters.extend([0.0; HIDDEN]);
    }
    Network { means: means.map(|m| m as f32), deviations, units: bandwidths, parameters }
}

/// Every `step`-th row of every example: its number and the row's.
fn rows_of(examples: &[Example], step: usize) -> Vec<(usize, usize)> {
    let of_example = |(number, example): (usize, &Example)| {
        let rows = (0..example.primary.size.height).step_by(step);
        rows.map(move |y| (number, y)).collect::<Vec<_>>()
    };
    examples.iter().enumerate().flat_map(of_example).collect()
}

/// Pulls all parameters towards 0, biases of outputs excepted: those are what the fixed filter was.
fn shrink(parameters: &mut [f32], share: f64) {
    let outputs = HIDDEN * (INPUTS + 1);
    for (i, parameter) in parameters.iter_mut().enumerate() {
        if i < outputs || !(i - outputs).is_multiple_of(HIDDEN + 1) {
            *parameter *= (1.0 - share) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use stack::Silent;

    use super::*;
    use crate::Settings;
    use crate::rivals::lbf::test_scene::{noisy_stack, reference};

    const TRAINING: TrainingSettings =
        TrainingSettings { radius: 3, epochs: 12, rows: 4, rate: 0.02, decay: 0.0, seed: 3 };

    fn examples() -> [Example; 2] {
        let settings = Settings::default().prefilter;
        [1, 2].map(|seed| Example::new(&noisy_stack(0.4, seed), &reference(), &settings, &Silent).unwrap())
    }

    #[test]
    fn a_search_finds_better_than_it_began_with_and_training_better_than_that() {
        let examples = examples();
        let rows = rows_of(&examples, 1);
        let batch = Batch { examples: &examples, rows: &rows, radius: TRAINING.radius };
        let fixed = best_fixed(&examples, TRAINING.radius, &Silent).unwrap();
        let network = train(&examples, fixed, &TRAINING, &Silent).unwrap();
        let begun = batch.error_of([1.0; TERMS], &Silent).unwrap();
        let (found, learned) = (batch.error_of(fixed, &Silent).unwrap(), batch.slope(&network, &Silent).unwrap().error);
        assert!(found < begun, "{found} {begun}");
        assert!(learned < 0.97 * found, "{learned} {found}");
    }

    #[test]
    fn the_slope_of_the_error_is_that_of_finite_differences() {
        let examples = examples();
        let rows = [(0, 3), (1, 8)];
        let batch = Batch { examples: &examples, rows: &rows, radius: TRAINING.radius };
        let mut network = start(examples.iter().flat_map(|e| &e.inputs), [1.0, 1.5, 2.0, 8.0, 8.0, 4.0], 1);
        let mut numbers = Numbers::new(9);
        let outputs = HIDDEN * (INPUTS + 1);
        network.parameters[outputs..].iter_mut().for_each(|p| *p += 0.3 * numbers.symmetric() as f32);
        let gradient = batch.slope(&network, &Silent).unwrap().gradient;
        let largest = gradient.iter().map(|g| g.abs()).fold(0.0, f64::max);
        for i in (0..PARAMETERS).step_by(41) {
            let error = |change: f32| {
                let mut network = network.clone();
                network.parameters[i] += change;
                batch.slope(&network, &Silent).unwrap().error
            };
            let expected = (error(1e-2) - error(-1e-2)) / 2e-2;
            assert!((gradient[i] - expected).abs() < 0.01 * largest, "{i}: {} {expected}", gradient[i]);
        }
    }

    #[test]
    fn weights_do_not_depend_on_the_number_of_threads() {
        let examples = examples();
        let settings = TrainingSettings { epochs: 2, ..TRAINING };
        let trained = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| train(&examples, [1.0; TERMS], &settings, &Silent).unwrap())
        };
        assert_eq!(trained(1), trained(3));
    }
}
