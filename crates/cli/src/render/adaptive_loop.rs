//! The loop: trace a little, reconstruct, look where the error is estimated highest, trace more there.

use std::time::Instant;

use anyhow::Result;
use reconstruct::adaptive::{ErrorEstimate, estimated_rmse, round_budget, sample_map};
use reconstruct::{ReconstructError, Reconstruction, reconstruct};
use stack::{FeatureStack, Image, Monitor, SampleCounts, SampleMap};
use tracer::camera::Camera;
use tracer::film::Film;
use tracer::integrator::{TraceError, TraceReport, passes_of, trace};
use tracer::scene::Scene;

use super::Budget;
use super::checkpoint::Checkpoint;
use super::finished::{Finished, Round};
use super::tev::Preview;
use super::time_left::TimeLeft;
use crate::interrupt;
use crate::progress::Progress;
use crate::settings::Settings;

/// A last round that the time cuts short adds at least one sample to so many that there are, or is left out.
const LEAST_GROWTH: u64 = 16;

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

/// Fills `film`, which may hold samples already, within `budget` and reconstructs its picture.
///
/// # Errors
/// When tracing or reconstruction fails; an interruption is no error.
pub fn trace_adaptively(sampling: &Sampling<'_>, film: Film, budget: &Budget, rebuild: bool) -> Result<Finished> {
    let mut state = State {
        sampling: *sampling,
        film,
        budget: *budget,
        time: TimeLeft::new(budget.time),
        rebuild,
        report: TraceReport::default(),
        rounds: Vec::new(),
    };
    let outcome = if budget.uniform || !rebuild { state.sample_uniformly() } else { state.sample_adaptively() };
    let interrupted = match outcome {
        Ok(()) => interrupt::requested(),
        Err(error) if is_cancelled(&error) => interrupt::requested(),
        Err(error) => return Err(error),
    };
    state.finish(interrupted)
}

/// The loop under way.
struct State<'a> {
    sampling: Sampling<'a>,
    film: Film,
    budget: Budget,
    time: TimeLeft,
    /// Whether the picture is reconstructed at the end.
    rebuild: bool,
    report: TraceReport,
    rounds: Vec<Round>,
}

impl State<'_> {
    fn pixels(&self) -> u64 {
        self.film.window().size.pixels() as u64
    }

    /// The same number of samples everywhere; in doubling steps, with a look at the picture after each, when time or error
    /// bound the work.
    fn sample_uniformly(&mut self) -> Result<()> {
        let spp = self.budget.spp.unwrap_or(u32::MAX);
        let has_target = self.budget.target_error.is_some();
        let in_steps = has_target || self.time.is_limited();
        let (_, least, _) = self.film.counts().mean_min_max();
        let mut step = if in_steps { self.sampling.settings.rounds.initial_spp } else { spp };
        loop {
            let level = least.saturating_add(step).min(spp);
            let is_all = self.trace(&self.film.samples_up_to(level))?;
            if !is_all || level == spp {
                self.note(None);
                return Ok(());
            }
            // What is not rebuilt needs no time for it.
            if has_target || self.rebuild {
                let (error, ..) = self.estimate()?;
                if self.budget.is_met_by(error) {
                    return Ok(());
                }
            }
            step = step.saturating_mul(2);
        }
    }

    /// First a few samples everywhere, then rounds that go where the error is (the paper, section 5).
    fn sample_adaptively(&mut self) -> Result<()> {
        let knobs = self.sampling.settings.rounds;
        let initial = self.budget.spp.map_or(knobs.initial_spp, |spp| spp.min(knobs.initial_spp));
        let mut goes_on = self.trace(&self.film.samples_up_to(initial))?;
        let mut round = 0;
        while goes_on && let Some(share) = self.share(round) {
            let (error, stack, reconstruction) = self.estimate()?;
            // Less time is left now.
            let share = self.in_time(share).filter(|_| !self.budget.is_met_by(error));
            let Some(share) = share else { return Ok(()) };
            goes_on = self.trace(&self.map(share, &stack, &reconstruction))?;
            round += 1;
        }
        Ok(())
    }

    /// How many samples round `round` may hand out: an equal share of what remains, or as many as were traced already
    /// when no number of samples bounds the work; no more than there is time for. `None` when nothing remains.
    fn share(&self, round: u32) -> Option<u64> {
        let share = match self.budget.spp {
            Some(spp) => {
                let rounds = self.sampling.settings.rounds.iterations.saturating_sub(round);
                let share = round_budget(u64::from(spp) * self.pixels(), self.film.samples(), u64::from(rounds));
                (share > 0 && rounds > 0).then_some(share)?
            }
            None => {
                // A film that was begun by an earlier run may have needed none yet.
                let least = u64::from(self.sampling.settings.rounds.initial_spp) * self.pixels();
                self.report.samples.max(least)
            }
        };
        self.in_time(share)
    }

    /// As many of `share` samples as there is time for; `None` when these are not worth the reconstruction that they cost.
    fn in_time(&self, share: u64) -> Option<u64> {
        let most = self.time.samples();
        (most >= share || most >= self.film.samples() / LEAST_GROWTH)
            .then_some(share.min(most))
            .filter(|share| *share > 0)
    }

    /// Takes the samples of `map`, as far as there is time; whether there was for all of them. A run takes some in any case.
    fn trace(&mut self, map: &SampleMap) -> Result<bool> {
        let Sampling { progress, checkpoint, .. } = self.sampling;
        progress.begin("trace", map.samples());
        if !self.time.is_limited() && checkpoint.is_none() {
            return self.trace_now(map).map(|()| true);
        }
        for pass in passes_of(map) {
            if self.report.samples > 0 && pass.samples() > self.time.samples() {
                return Ok(false);
            }
            self.trace_now(&pass)?;
            if let Some(checkpoint) = checkpoint.filter(|checkpoint| checkpoint.is_due()) {
                checkpoint.reach(&self.film.to_stack(), progress);
            }
        }
        Ok(true)
    }

    fn trace_now(&mut self, map: &SampleMap) -> Result<()> {
        let Sampling { scene, camera, settings, progress, .. } = self.sampling;
        let begun = Instant::now();
        match trace(scene, camera, &mut self.film, map, &settings.trace, &SameStage(progress)) {
            Ok(report) => self.report = self.report.plus(report),
            Err(TraceError::Cancelled(report)) => {
                self.report = self.report.plus(report);
                return Err(stack::Cancelled.into());
            }
            Err(error) => return Err(error.into()),
        }
        self.time.note_traced(begun, map.samples());
        Ok(())
    }

    /// Reconstructs with the small window of the iterations; the estimated error, and what it rests on.
    fn estimate(&mut self) -> Result<(f64, FeatureStack, Reconstruction)> {
        let begun = Instant::now();
        let stack = self.film.to_stack();
        let reconstruction = reconstruct(&stack, &self.sampling.settings.between_rounds(), self.sampling.progress)?;
        let error = estimated_rmse(&reconstruction.mse, &reconstruction.picture);
        self.note(Some(error));
        self.sampling.show(&reconstruction.picture, &reconstruction.mse);
        self.time.note_estimated(begun);
        Ok((error, stack, reconstruction))
    }

    /// Where `share` samples shall go, from what was made of `stack`.
    fn map(&self, share: u64, stack: &FeatureStack, reconstruction: &Reconstruction) -> SampleMap {
        let estimate = ErrorEstimate {
            mse: &reconstruction.mse,
            picture: &reconstruction.picture,
            rank: reconstruction.rank.as_deref(),
            counts: &stack.samples,
        };
        sample_map(&estimate, share, &self.sampling.settings.sampling)
    }

    fn note(&mut self, estimated_rmse: Option<f64>) {
        self.rounds.push(round(self.film.counts(), &self.time, estimated_rmse));
    }

    fn finish(self, interrupted: bool) -> Result<Finished> {
        let Self { sampling, film, budget, time, rebuild, report, mut rounds } = self;
        let mut finished = Finished { interrupted, ..Finished::unrebuilt(film.into_stack(), &report) };
        if sampling.preview.is_some() {
            // Of samples that are not rebuilt no error is known.
            let unknown = vec![f32::NAN; finished.stack.size().pixels()];
            sampling.show(&finished.stack.beauty(), &unknown);
        }
        if rebuild && !interrupted {
            match reconstruct(&finished.stack, &sampling.settings.reconstruction, sampling.progress) {
                Ok(reconstruction) => {
                    let error = estimated_rmse(&reconstruction.mse, &reconstruction.picture);
                    rounds.push(round(&finished.stack.samples, &time, Some(error)));
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
fn round(counts: &SampleCounts, time: &TimeLeft, estimated_rmse: Option<f64>) -> Round {
    let (spp, ..) = counts.mean_min_max();
    Round { spp, estimated_rmse, seconds: time.spent() }
}

/// Tells of work within a stage that has begun already: all but its beginning.
struct SameStage<'a>(&'a Progress);

impl Monitor for SameStage<'_> {
    fn advance(&self, units: u64) {
        self.0.advance(units);
    }

    fn note(&self, line: &str) {
        self.0.note(line);
    }

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

fn is_cancelled(error: &anyhow::Error) -> bool {
    let in_reconstruction = || matches!(error.downcast_ref(), Some(ReconstructError::Cancelled(_)));
    error.is::<stack::Cancelled>() || in_reconstruction()
}
