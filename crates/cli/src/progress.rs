//! Progress on standard error, and the time each stage took.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use stack::Monitor;

use crate::args::ReportArgs;
use crate::stderr::say_line;
use crate::{interrupt, log_file};

/// Draws a bar when standard error is a terminal, times stages, and cancels on Ctrl-C.
pub struct Progress {
    bar: ProgressBar,
    quiet: bool,
    verbose: bool,
    stages: Mutex<Stages>,
}

#[derive(Default)]
struct Stages {
    running: Option<(&'static str, Instant)>,
    /// What the running stage says its time went to.
    steps: Vec<(&'static str, f64)>,
    seconds: Vec<(&'static str, f64)>,
}

impl Progress {
    /// A monitor that says as much as `report` asks for.
    pub fn new(report: &ReportArgs) -> Self {
        let draw = !report.quiet && std::io::stderr().is_terminal();
        let target = if draw { ProgressDrawTarget::stderr_with_hz(10) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let template = "{msg:>12} {wide_bar} {percent:>3} %  {left:>16}";
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let left = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
            let _ = out.write_str(&time_left(state.pos(), state.eta()));
        };
        bar.set_style(style.with_key("left", left));
        Self { bar, quiet: report.quiet, verbose: report.verbose, stages: Mutex::default() }
    }

    /// Says one line, unless quiet; the log has it in any case.
    pub fn say(&self, line: &str) {
        log_file::add(line);
        self.print(line);
    }

    fn print(&self, line: &str) {
        if !self.quiet {
            self.bar.suspend(|| say_line(line));
        }
    }

    /// Says one line when asked to say more.
    pub fn whisper(&self, line: &str) {
        log_file::add(line);
        if self.verbose {
            self.print(line);
        }
    }

    /// Ends the running stage.
    pub fn finish(&self) {
        self.switch(None);
        self.bar.finish_and_clear();
    }

    /// Seconds spent in stage `name`, all its runs together.
    pub fn seconds(&self, name: &str) -> f64 {
        self.stage_seconds().iter().find(|(stage, _)| *stage == name).map_or(0.0, |(_, seconds)| *seconds)
    }

    /// Seconds of every stage so far, in order of first appearance.
    pub fn stage_seconds(&self) -> Vec<(&'static str, f64)> {
        self.stages.lock().map(|stages| stages.seconds.clone()).unwrap_or_default()
    }

    /// Seconds of all stages together.
    pub fn total_seconds(&self) -> f64 {
        // From 0 on: the sum of nothing is -0.
        self.stage_seconds().iter().fold(0.0, |sum, (_, seconds)| sum + seconds)
    }

    fn switch(&self, next: Option<&'static str>) {
        let Ok(mut stages) = self.stages.lock() else { return };
        let now = Instant::now();
        if let Some((name, since)) = stages.running.take() {
            stages.divide(name, (now - since).as_secs_f64());
        }
        stages.running = next.map(|name| (name, now));
    }
}

/// How long the stage still takes: nothing is known of that before a part of it is `done`.
fn time_left(done: u64, left: Duration) -> String {
    if done == 0 { String::new() } else { format!("{} left", HumanDuration(left)) }
}

impl Stages {
    /// Books a stage's time, shared among its steps when it has told of any.
    fn divide(&mut self, name: &'static str, spent: f64) {
        let steps = std::mem::take(&mut self.steps);
        let total: f64 = steps.iter().map(|(_, seconds)| seconds).sum();
        if total > 0.0 {
            steps.iter().for_each(|(step, seconds)| self.add(step, spent * seconds / total));
        } else {
            self.add(name, spent);
        }
    }

    fn add(&mut self, name: &'static str, spent: f64) {
        match self.seconds.iter_mut().find(|(stage, _)| *stage == name) {
            Some((_, seconds)) => *seconds += spent,
            None => self.seconds.push((name, spent)),
        }
    }
}

impl Monitor for Progress {
    fn begin(&self, stage: &'static str, units: u64) {
        self.switch(Some(stage));
        self.bar.reset();
        self.bar.set_length(units);
        self.bar.set_message(stage);
    }

    fn advance(&self, units: u64) {
        self.bar.inc(units);
    }

    fn spent(&self, step: &'static str, seconds: f64) {
        if let Ok(mut stages) = self.stages.lock() {
            stages.steps.push((step, seconds));
        }
    }

    fn note(&self, line: &str) {
        self.say(line);
    }

    fn cancelled(&self) -> bool {
        interrupt::requested()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_that_has_just_begun_does_not_say_that_it_ends() {
        assert_eq!(time_left(0, Duration::ZERO), "");
        assert_eq!(time_left(1, Duration::from_secs(5)), "5 seconds left");
    }
}
