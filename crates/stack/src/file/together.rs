//! Puts one render, two halves or several buckets together to a feature stack.

use std::path::PathBuf;

use super::counts::Spp;
use super::emission::split_emission;
use super::independence::{check_independent, is_unlike};
use super::loaded::{Loaded, Plane, mend_all};
use super::role::Role;
use super::shared_noise::shares_noise;
use super::write::may_write;
use super::{FileError, Found, Passthrough, ReadStack};
use crate::{
    Component, ComponentRole, Dealing, Estimate, Feature, FeatureRole, FeatureStack, Image, Noise, SampleCounts,
};

/// What is said where [`shares_noise`].
const SHARED_NOISE: &str = "neighbouring pixels share their noise, as after a pixel filter wider than a pixel, so that less of it \
                            is taken off: render with a box filter, or one that is sampled";

/// The stack of one render; what is known about its noise is in its own files.
pub fn alone(render: Loaded) -> ReadStack {
    let mut renders = [render];
    mend_all(&mut renders);
    let [mut render] = renders;
    let samples = counts_alone(&mut render);
    if shares_noise(&render) {
        render.found.remarks.push(SHARED_NOISE.into());
    }
    let mut planes = std::mem::take(&mut render.planes);
    split_emission(&mut planes, &mut render.found.remarks);
    let mut estimates = Vec::new();
    for plane in planes {
        let estimate = match render.noise_of(&plane) {
            Noise::Buckets(halves) => Estimate::from_buckets(halves, &samples),
            noise => Estimate { mean: plane.mean, noise },
        };
        estimates.push((plane.role, estimate));
    }
    finish(render, samples, estimates)
}

/// Counts of one render: with halves, the samples with even numbers and those with odd ones.
fn counts_alone(render: &mut Loaded) -> SampleCounts {
    let pixels = render.rest.window.size.pixels();
    let halves = render.planes.iter().find(|plane| plane.halves.is_some());
    if let Some(spp) = render.spp.as_ref().filter(|spp| halves.is_some() && !spp.is_uniform()) {
        let half = |of: fn(u32) -> u32| spp.total.iter().map(|n| of((*n).max(1))).collect();
        return SampleCounts::per_pixel(vec![half(|n| n.div_ceil(2)), half(|n| n / 2)]);
    }
    let per_bucket = match (&render.spp, halves) {
        (Some(spp), Some(_)) => {
            let n = spp.mean().round() as u32;
            vec![n.div_ceil(2), n / 2]
        }
        (Some(spp), None) => vec![spp.mean().round() as u32],
        (None, Some(plane)) => fitted_halves(plane),
        (None, None) => vec![1],
    };
    match &render.spp {
        Some(spp) => SampleCounts { first: 0, total: spp.total.clone(), dealing: Dealing::PerBucket(per_bucket) },
        None => SampleCounts::uniform(pixels, per_bucket),
    }
}

/// How many samples two halves hold, told from their mean: w A + (1 − w) B with w = ⌈n/2⌉/n.
fn fitted_halves(plane: &Plane) -> Vec<u32> {
    let Some([a, b]) = &plane.halves else { return vec![1] };
    let (mut along, mut all) = (0.0_f64, 0.0_f64);
    for ((a, b), m) in a.channels().iter().zip(b.channels()).zip(plane.mean.channels()) {
        for ((a, b), m) in a.iter().zip(b).zip(m) {
            let difference = f64::from(a - b);
            along += difference * f64::from(m - b);
            all += difference * difference;
        }
    }
    let odd = 2.0 * along / all - 1.0;
    // Beyond some ten samples one more in a half makes no difference, and rounding hides it.
    if odd.is_finite() && (0.08..=1.0).contains(&odd) {
        let n = ((1.0 / odd).round() as u32).max(3);
        return vec![n.div_ceil(2), n / 2];
    }
    vec![1, 1]
}

/// The stack of several independent renders of one picture. A feature must be in all of them; with `halves`, one that
/// is not is left out.
///
/// # Errors
/// When features differ, or two renders hold the same noise.
pub fn several(
    mut renders: Vec<Loaded>,
    paths: &[PathBuf],
    given: &[u32],
    halves: bool,
) -> Result<ReadStack, FileError> {
    let colours: Vec<&Image> = renders.iter().filter_map(|r| r.plane(Role::Colour)).map(|p| &p.mean).collect();
    check_independent(paths, &colours)?;
    mend_all(&mut renders);
    let samples = counts_of(&renders, given);
    for render in &mut renders {
        render.planes.iter_mut().for_each(|plane| (plane.halves, plane.measured) = (None, None));
        split_emission(&mut render.planes, &mut render.found.remarks);
    }
    let mut means: Vec<Vec<(Role, Image)>> = renders
        .iter_mut()
        .map(|render| render.planes.drain(..).map(|plane| (plane.role, plane.mean)).collect())
        .collect();
    join_emission(&mut means);
    let mut first = renders.swap_remove(0);
    first.found.remarks.extend(what_differs(&means));
    if given.len() != paths.len() && renders.iter().any(|render| render.spp.is_none()) {
        // They count alike then, and what the first says is not how many there are.
        first.spp = None;
    }
    let mut roles: Vec<Role> = Vec::new();
    for (role, _) in means.iter().flatten() {
        if !roles.contains(role) {
            roles.push(*role);
        }
    }
    let mut estimates = Vec::new();
    for role in roles {
        let buckets: Vec<Option<Image>> = means.iter_mut().map(|planes| take(planes, role)).collect();
        let absent = buckets.iter().position(Option::is_none);
        match absent {
            Some(_) if halves => {
                first.found.remarks.push(format!("{} is in one half alone, and is not used", role.name()));
                first.found.roles.retain(|found| found.role != role.name());
                continue;
            }
            Some(which) => return Err(missing(&paths[which], role)),
            None => {}
        }
        estimates.push((role, Estimate::from_buckets(buckets.into_iter().flatten().collect(), &samples)));
    }
    Ok(finish(first, samples, estimates))
}

/// What is said of the first render that shows something else than the first of all.
fn what_differs(means: &[Vec<(Role, Image)>]) -> Option<String> {
    let (first, others) = means.split_first()?;
    let unlike = |other: &Vec<(Role, Image)>| -> Vec<&str> {
        let pairs = first.iter().filter_map(|(role, a)| Some((role, a, &other.iter().find(|(r, _)| r == role)?.1)));
        pairs.filter(|(_, a, b)| is_unlike(a, b)).map(|(role, ..)| role.name()).collect()
    };
    let (nth, roles) = others.iter().map(unlike).enumerate().find(|(_, roles)| !roles.is_empty())?;
    Some(format!(
        "render {} hardly resembles render 1 in {}: halves and buckets are renders of one picture",
        nth + 2,
        roles.join(", ")
    ))
}

fn take(planes: &mut Vec<(Role, Image)>, role: Role) -> Option<Image> {
    planes.iter().position(|(r, _)| *r == role).map(|at| planes.swap_remove(at).1)
}

/// Emission is a component of its own in all renders or in none.
fn join_emission(means: &mut [Vec<(Role, Image)>]) {
    let has = |planes: &Vec<(Role, Image)>| planes.iter().any(|(role, _)| *role == Role::Emission);
    if means.iter().all(has) {
        return;
    }
    for planes in means {
        if let Some(emission) = take(planes, Role::Emission) {
            planes.iter_mut().filter(|(role, _)| *role == Role::Colour).for_each(|(_, colour)| colour.add(&emission));
        }
    }
}

fn missing(path: &std::path::Path, role: Role) -> FileError {
    FileError::Missing {
        path: path.into(),
        wanted: role.name(),
        expected: "of what the other renders have".into(),
        found: "none of that role".into(),
    }
}

/// Samples of each render: as given, else what all the files say, pixel by pixel where that differs, else equally many.
fn counts_of(renders: &[Loaded], given: &[u32]) -> SampleCounts {
    let pixels = renders[0].rest.window.size.pixels();
    if given.len() == renders.len() {
        return SampleCounts::uniform(pixels, given.to_vec());
    }
    let known: Option<Vec<_>> = renders.iter().map(|render| render.spp.clone()).collect();
    let Some(known) = known else { return SampleCounts::uniform(pixels, vec![1; renders.len()]) };
    if known.iter().all(Spp::is_uniform) {
        return SampleCounts::uniform(pixels, known.iter().map(|spp| spp.total[0].max(1)).collect());
    }
    let mut planes: Vec<Vec<u32>> = known.into_iter().map(|spp| spp.total).collect();
    // Where no render admits to a sample, they count alike: each has a value there.
    for pixel in (0..pixels).filter(|pixel| planes.iter().all(|plane| plane[*pixel] == 0)).collect::<Vec<_>>() {
        planes.iter_mut().for_each(|plane| plane[pixel] = 1);
    }
    SampleCounts::per_pixel(planes)
}

/// The output's picture is bare `R G B`, whatever it was called: so its alpha must be `A`, or it is nobody's.
fn add_bare_alpha(passthrough: &mut Vec<Passthrough>, found: &Found) {
    let Some(alpha) = found.roles.iter().find(|role| role.role == Role::Alpha.name()) else { return };
    if passthrough.iter().any(|channel| channel.name == "A") {
        return;
    }
    let own = passthrough.iter().find(|channel| alpha.channels.contains(&channel.name));
    let bare = own.map(|own| Passthrough { name: "A".into(), samples: own.samples.clone() });
    passthrough.extend(bare);
}

fn finish(render: Loaded, samples: SampleCounts, estimates: Vec<(Role, Estimate)>) -> ReadStack {
    let Loaded { mut found, rest, spp, .. } = render;
    let (mut components, mut features) = (Vec::new(), Vec::new());
    for (role, estimate) in estimates {
        match role {
            Role::Colour => components.push(Component { role: ComponentRole::Scattered, radiance: estimate }),
            Role::Emission => components.push(Component { role: ComponentRole::Emission, radiance: estimate }),
            Role::Feature(role) => features.push(Feature { role, estimate }),
            Role::Alpha | Role::Samples => {}
        }
    }
    features.sort_by_key(|feature| FeatureRole::ALL.iter().position(|role| *role == feature.role));
    let mut passthrough = rest.channels;
    let names: Vec<String> = passthrough.iter().filter(|c| may_write(&c.name)).map(|c| c.name.clone()).collect();
    passthrough.retain(|channel| !may_write(&channel.name));
    add_bare_alpha(&mut passthrough, &found);
    if !names.is_empty() {
        found.remarks.push(format!("not kept, since the output has channels of these names: {}", names.join(" ")));
    }
    if !rest.carried.refused().is_empty() {
        let names = rest.carried.refused().join(" ");
        found.remarks.push(format!("not kept, since OpenEXR has another type for attributes of these names: {names}"));
    }
    let (window, film) = (rest.window, rest.film);
    let stack =
        FeatureStack { window, film, samples, components, indirect: None, gathered: None, features, passthrough };
    found.spp = spp.map(|_| {
        let (mean, min, max) = stack.samples.mean_min_max();
        let from = found.spp.as_ref().map_or_else(String::new, |spp| spp.from.clone());
        super::found::FoundSpp { mean, min, max, from }
    });
    found.conclude(&stack);
    let notes = found.lines();
    ReadStack { stack, header: None, notes, found, carried: rest.carried }
}
