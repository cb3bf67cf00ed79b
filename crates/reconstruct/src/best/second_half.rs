//! The second pass and the choice among its candidates, band by band.

use std::borrow::Cow;

use stack::{Cancelled, Image, Monitor};

use super::choice::{self, mixtures};
use super::piloted::Piloted;
use super::recipe::Recipe;
use super::second_pass;
use crate::bands::bands;
use crate::collaborative::period;

/// Both halves of the low layer as the second pass and the choice make them, and the passes; where there is but one pass
/// of regressions, what that made.
///
/// # Errors
/// When `monitor` cancels.
pub fn second_half(
    recipe: &Recipe,
    piloted: &Piloted,
    monitor: &dyn Monitor,
) -> Result<([Image; 2], Vec<Image>), Cancelled> {
    let fit = &recipe.settings.regression;
    if fit.passes < 2 {
        let passes = piloted.passes.iter().map(|pass| pass.first.clone());
        return Ok((piloted.first.clone(), passes.collect()));
    }
    let (size, period) = (piloted.pilot.size(), period(fit.stride));
    let margin = (second_pass::reach(fit) + choice::REACH).next_multiple_of(period);
    let rows = recipe.extras.rows.clamp(1, size.height.max(1)).next_multiple_of(period);
    let black = || Image::zeros(size, 3);
    let mut halves = [black(), black()];
    let mut passes: Vec<Image> = piloted.passes.iter().map(|_| black()).collect();
    for band in bands(size.height, rows, margin) {
        let part = match band.is_whole(size.height) {
            true => Cow::Borrowed(piloted),
            false => Cow::Owned(piloted.rows(&band.around)),
        };
        let (some_halves, some_passes) = at_once(recipe, &part, monitor)?;
        let made = some_halves.iter().chain(&some_passes);
        made.zip(halves.iter_mut().chain(&mut passes)).for_each(|(made, whole)| band.put(made, whole));
    }
    Ok((halves, passes))
}

/// The same of all rows of `piloted` at once.
fn at_once(recipe: &Recipe, piloted: &Piloted, monitor: &dyn Monitor) -> Result<([Image; 2], Vec<Image>), Cancelled> {
    let fit = &recipe.settings.regression;
    let candidates = piloted.candidates(&piloted.given.low.halves, &piloted.first, fit, monitor)?;
    monitor.begin("choice", 1);
    let chooser = recipe.chooser.filter(|_| recipe.settings.choice.learned);
    let weights = choice::weights(&piloted.contest(&candidates), &recipe.settings.choice, chooser);
    let halves = mixtures(&candidates, weights.channels());
    drop(candidates);
    let mut passes = Vec::new();
    // Two at a time take the place of the halves.
    for pair in piloted.passes.chunks(2) {
        let both = [&pair[0], pair.last().unwrap_or(&pair[0])];
        let (low, first) = (both.map(|pass| pass.low.clone()), both.map(|pass| pass.first.clone()));
        let candidates = piloted.candidates(&low, &first, fit, monitor)?;
        passes.extend(mixtures(&candidates, weights.channels()).into_iter().take(pair.len()));
    }
    Ok((halves, passes))
}
