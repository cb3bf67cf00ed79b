//! The loop: trace a little, reconstruct, look where the error is estimated highest, trace more there.

use std::time::{Duration, Instant};

use anyhow::Result;
use reconstruct::adaptive::{ErrorEstimate, estimated_rmse, round_budget, sample_map};
use reconstruct::{ReconstructError, Reconstruction, reconstruct};
use stack::{FeatureStack, Image, SampleCounts, SampleMap};
use tracer::camera::Camera;
use tracer::film::Film;
use tracer::integrator::{TraceError, TraceReport, trace};
use tracer::scene::Scene;

use super::checkpoint::Checkpoint;
use super::tev::Preview;
use crate::interrupt;
use crate::progress::Progress;
use crate::settings::Settings;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Number of the first sample.
    pub first: u32,
    /// Mean samples per pixel, when that bounds the work.
    pub spp: Option<u32>,
    /// Time for tracing and reconstruction.
    pub time: Duration,
    /// Estimated relative MSE that is good enough.
    pub target_error: Option<f32>,
    /// The same number of samples everywhere.
    pub uniform: bool,
}

impl Budget {
    /// `spp` samples for every pixel.
    pub const fn uniform(spp: u32) -> Self {
        Self { first: 0, spp: Some(spp), time: Duration::MAX, target_error: None, uniform: true }
    }

    /// Whether `counts` are as many samples as may be taken.
    pub fn is_spent_by(&self, counts: &SampleCounts) -> bool {
        let Some(spp) = self.spp else { return false };
        let (mean, least, _) = counts.mean_min_max();
        if self.uniform { least >= spp } else { mean >= f64::from(spp) }
    }

    /// Whether an estimated `error` is as low as the target, if there is one.
    fn is_met_by(&self, error: f64) -> bool {
        self.target_error.is_some_and(|target| error <= f64::from(target))
    }
}

/// What the loop works with.
#[derive(Clone, Copy)]
pub struct Sampling<'a> {
    pub scene: &'a Scene,
    pub camera: &'a Camera,
    pub settings: &'a Settings,
    pub progress: &'a Progress,
    /// Where pictures are shown while they are made.
    pub preview: Option<&'a Preview>,
    /// Where samples are kept while more are taken.
    pub checkpoint: Option<&'a Checkpoint<'a>>,
}

impl Sampling<'_> {
    fn show(&self, picture: &Image, mse: &[f32]) {
        if let Some(preview) = self.preview {
            preview.show(picture, mse, self.progress);
        }
    }
}

/// One turn of the loop.
#[derive(Clone, Copy, Debug)]
pub struct Round {
    /// Mean samples per pixel at its end.
    pub spp: f64,
    /// Estimated relative MSE of the picture then.
    pub estimated_rmse: Option<f64>,
    /// Seconds since the loop began.
    pub seconds: f64,
}

/// What the loop leaves.
pub struct Finished {
    pub stack: FeatureStack,
    pub reconstruction: Option<Reconstruction>,
    pub rounds: Vec<Round>,
    /// Samples that were traced; a film that was begun by an earlier run holds more.
    pub samples: u64,
    pub rays: u64,
    /// Samples that were NaN or infinite and count as zero.
    pub not_finite: u64,
    /// Whether Ctrl-C ended it.
    pub interrupted: bool,
    /// A target error was given and not reached.
    pub missed_target: bool,
}

/// Fills `film`, which may hold samples already, within `budget` and reconstructs its picture.
///
/// # Errors
/// When tracing or reconstruction fails; an interruption is no error.
pub fn trace_adaptively(sampling: &Sampling<'_>, film: Film, budget: &Budget, rebuild: bool) -> Result<Finished> {
    let mut state = State {
        sampling: *sampling,
        film,
        budget: *budget,
        start: Instant::now(),
        report: TraceReport::default(),
        rounds: Vec::new(),
    };
    let outcome = if budget.uniform || !rebuild { state.sample_uniformly() } else { state.sample_adaptively() };
    let interrupted = match outcome {
        Ok(()) => interrupt::requested(),
        Err(error) if is_cancelled(&error) => interrupt::requested(),
        Err(error) => return Err(error),
    };
    state.finish(interrupted, rebuild)
}

/// The loop under way.
struct State<'a> {
    sampling: Sampling<'a>,
    film: Film,
    budget: Budget,
    start: Instant,
    report: TraceReport,
    rounds: Vec<Round>,
}

impl State<'_> {
    fn pixels(&self) -> u64 {
        self.film.window().size.pixels() as u64
    }

    /// The same number of samples everywhere, in doubling steps when only time or error bound the work.
    fn sample_uniformly(&mut self) -> Result<()> {
        if let Some(spp) = self.budget.spp {
            self.trace(&self.film.samples_up_to(spp))?;
            self.note(None);
            return Ok(());
        }
        let mut done = 0;
        let mut step = self.sampling.settings.rounds.initial_spp;
        while !self.out_of_time(step as f64 / f64::from(done.max(1))) {
            self.trace(&self.film.next_samples(step))?;
            done += step;
            step = done;
            let (error, ..) = self.estimate()?;
            if self.budget.is_met_by(error) {
                break;
            }
        }
        Ok(())
    }

    /// First a few samples everywhere, then rounds that go where the error is (the paper, section 5).
    fn sample_adaptively(&mut self) -> Result<()> {
        let knobs = self.sampling.settings.rounds;
        let initial = self.budget.spp.map_or(knobs.initial_spp, |spp| spp.min(knobs.initial_spp));
        self.trace(&self.film.samples_up_to(initial))?;
        let mut round = 0;
        loop {
            let Some(share) = self.share(round) else { return Ok(()) };
            let (error, map) = self.estimate_and_map(share)?;
            if self.budget.is_met_by(error) {
                return Ok(());
            }
            self.trace(&map)?;
            round += 1;
        }
    }

    /// How many samples round `round` may hand out: an equal share of what remains, or as many as were traced already
    /// when no number of samples bounds the work. `None` when nothing remains.
    fn share(&self, round: u32) -> Option<u64> {
        match self.budget.spp {
            Some(spp) => {
                let rounds = self.sampling.settings.rounds.iterations.saturating_sub(round);
                let share = round_budget(u64::from(spp) * self.pixels(), self.film.samples(), u64::from(rounds));
                (share > 0 && rounds > 0 && !self.out_of_time(0.0)).then_some(share)
            }
            None => {
                // A film that was begun by an earlier run may have needed none yet.
                let least = u64::from(self.sampling.settings.rounds.initial_spp) * self.pixels();
                (!self.out_of_time(1.0)).then_some(self.report.samples.max(least))
            }
        }
    }

    /// Whether `growth` times what was traced so far, and the last reconstruction, no longer fit.
    fn out_of_time(&self, growth: f64) -> bool {
        let spent = self.start.elapsed().as_secs_f64();
        let traced = self.sampling.progress.seconds("trace");
        // The last reconstruction has the larger window: about four times the work of one while iterating.
        let rebuilding = if self.rounds.is_empty() { 0.0 } else { 4.0 * (spent - traced) / self.rounds.len() as f64 };
        spent + growth * traced + rebuilding > self.budget.time.as_secs_f64()
    }

    fn trace(&mut self, map: &SampleMap) -> Result<()> {
        let Sampling { scene, camera, settings, progress, .. } = self.sampling;
        match trace(scene, camera, &mut self.film, map, &settings.trace, progress) {
            Ok(report) => self.report = self.report.plus(report),
            Err(TraceError::Cancelled(report)) => {
                self.report = self.report.plus(report);
                return Err(stack::Cancelled.into());
            }
            Err(error) => return Err(error.into()),
        }
        Ok(())
    }

    /// Reconstructs with the small window of the iterations; the estimated error, and what it rests on.
    fn estimate(&mut self) -> Result<(f64, FeatureStack, Reconstruction)> {
        let stack = self.film.to_stack();
        if let Some(checkpoint) = self.sampling.checkpoint {
            checkpoint.reach(&stack, self.sampling.progress);
        }
        let reconstruction = reconstruct(&stack, &self.iteration_settings(), self.sampling.progress)?;
        let error = estimated_rmse(&reconstruction.mse, &reconstruction.picture);
        self.note(Some(error));
        self.sampling.show(&reconstruction.picture, &reconstruction.mse);
        Ok((error, stack, reconstruction))
    }

    fn estimate_and_map(&mut self, share: u64) -> Result<(f64, SampleMap)> {
        let (error, stack, reconstruction) = self.estimate()?;
        let estimate = ErrorEstimate {
            mse: &reconstruction.mse,
            picture: &reconstruction.picture,
            rank: reconstruction.rank.as_deref(),
            counts: &stack.samples,
        };
        let map = sample_map(&estimate, share, &self.sampling.settings.sampling);
        Ok((error, map))
    }

    fn iteration_settings(&self) -> reconstruct::Settings {
        let rounds = &self.sampling.settings.rounds;
        let mut settings = self.sampling.settings.reconstruction;
        settings.regression.window.radius = rounds.iteration_radius;
        settings.best.light.apart &= rounds.iteration_apart;
        // Samples go by the error, which knows nothing of clouds.
        settings.best.clouds.levels = 0;
        let fit = &mut settings.best.regression;
        fit.stride = rounds.iteration_stride;
        fit.passes = rounds.iteration_passes;
        fit.second_radius = rounds.iteration_second_radius;
        settings
    }

    fn note(&mut self, estimated_rmse: Option<f64>) {
        self.rounds.push(round(self.film.counts(), self.start, estimated_rmse));
    }

    fn finish(self, interrupted: bool, rebuild: bool) -> Result<Finished> {
        let Self { sampling, film, budget, start, report, mut rounds } = self;
        let mut finished = Finished {
            stack: film.into_stack(),
            reconstruction: None,
            rounds: Vec::new(),
            samples: report.samples,
            rays: report.rays,
            not_finite: report.not_finite,
            interrupted,
            missed_target: false,
        };
        if sampling.preview.is_some() {
            // Of samples that are not rebuilt no error is known.
            let unknown = vec![f32::NAN; finished.stack.size().pixels()];
            sampling.show(&finished.stack.beauty(), &unknown);
        }
        if rebuild && !interrupted {
            match reconstruct(&finished.stack, &sampling.settings.reconstruction, sampling.progress) {
                Ok(reconstruction) => {
                    let error = estimated_rmse(&reconstruction.mse, &reconstruction.picture);
                    rounds.push(round(&finished.stack.samples, start, Some(error)));
                    finished.missed_target = budget.target_error.is_some() && !budget.is_met_by(error);
                    sampling.show(&reconstruction.picture, &reconstruction.mse);
                    finished.reconstruction = Some(reconstruction);
                }
                Err(ReconstructError::Cancelled(_)) => finished.interrupted = true,
                Err(error) => return Err(error.into()),
            }
        }
        finished.rounds = rounds;
        Ok(finished)
    }
}

/// What there is now.
fn round(counts: &SampleCounts, start: Instant, estimated_rmse: Option<f64>) -> Round {
    let (spp, ..) = counts.mean_min_max();
    Round { spp, estimated_rmse, seconds: start.elapsed().as_secs_f64() }
}

fn is_cancelled(error: &anyhow::Error) -> bool {
    let in_reconstruction = || matches!(error.downcast_ref(), Some(ReconstructError::Cancelled(_)));
    error.is::<stack::Cancelled>() || in_reconstruction()
}
