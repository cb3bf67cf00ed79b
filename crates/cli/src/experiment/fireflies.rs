//! Spikes that were planted, and marks where there are none.

use anyhow::Result;
use reconstruct::spikes::{SpikeSettings, remove_spikes};
use stack::{Image, Knobs, Size};

use crate::failure::usage;
use crate::progress::Progress;
use crate::table::Table;

const SIZE: Size = Size::new(128, 128);

/// Radiance of the wall and standard deviation of its noise.
const WALL: (f32, f32) = (0.5, 0.05);

/// One pixel in this many holds a planted spike.
const EVERY: usize = 331;

type Variant = (&'static str, &'static [(&'static str, &'static str)]);

const VARIANTS: [Variant; 4] = [
    ("literal (2.5, one iteration)", &[]),
    ("2.5 × log-average", &[("spike-threshold-unit", "log-average")]),
    ("2.5 × log-average, 30 iterations", &[("spike-threshold-unit", "log-average"), ("spike-iterations", "30")]),
    (
        "0.5 × log-average, 30 iterations",
        &[("spike-threshold-unit", "log-average"), ("spike-iterations", "30"), ("spike-threshold", "0.5")],
    ),
];

/// Runs the experiment.
pub fn run(progress: &Progress) -> Result<Vec<Table>> {
    let head = ["variant", "10 σ", "20 σ", "40 σ", "80 σ", "40 σ, a hundred times darker", "wall", "checker", "lamp"];
    let mut table = Table::new("Planted spikes found; pixels marked where there are none", &head);
    for (name, flags) in VARIANTS {
        let mut settings = SpikeSettings::DEFAULT;
        for (flag, value) in flags {
            settings.set(flag, value).ok_or_else(|| usage(format!("no setting of spikes is called {flag}")))??;
        }
        let mut row = vec![name.to_string()];
        for sigmas in [10.0, 20.0, 40.0, 80.0] {
            row.push(found(&planted(sigmas, 1.0), &settings, progress)?);
        }
        row.push(found(&planted(40.0, 0.01), &settings, progress)?);
        for picture in [noisy(|_, _| WALL.0), noisy(checker), noisy(lamp)] {
            row.push(percent(marks(&picture, &settings, progress)?.iter().filter(|m| **m).count(), SIZE.pixels()));
        }
        table.rows.push(row);
    }
    Ok(vec![table])
}

fn checker(x: usize, y: usize) -> f32 {
    if (x / 8 + y / 8).is_multiple_of(2) { 0.1 } else { 0.9 }
}

fn lamp(x: usize, y: usize) -> f32 {
    let inside = |v: usize| (50..64).contains(&v);
    if inside(x) && inside(y) { 20.0 } else { WALL.0 }
}

fn noisy(f: impl Fn(usize, usize) -> f32) -> Image {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1_u64 << 24) as f32
    };
    // The sum of twelve uniform numbers is as good as normal here.
    let mut noise = || WALL.1 * ((0..12).map(|_| uniform()).sum::<f32>() - 6.0);
    let plane: Vec<f32> = (0..SIZE.pixels()).map(|i| (f(i % SIZE.width, i / SIZE.width) + noise()).max(0.0)).collect();
    Image::from_channels(SIZE, vec![plane; 3])
}

fn planted(sigmas: f32, exposure: f32) -> Image {
    let mut picture = noisy(|_, _| WALL.0);
    for plane in picture.channels_mut() {
        plane.iter_mut().step_by(EVERY).for_each(|value| *value += sigmas * WALL.1);
        plane.iter_mut().for_each(|value| *value *= exposure);
    }
    picture
}

fn marks(picture: &Image, settings: &SpikeSettings, progress: &Progress) -> Result<Vec<bool>> {
    Ok(remove_spikes(picture, &Image::zeros(SIZE, 3), settings, progress)?.marked)
}

fn found(picture: &Image, settings: &SpikeSettings, progress: &Progress) -> Result<String> {
    let marks = marks(picture, settings, progress)?;
    let planted = marks.iter().step_by(EVERY);
    Ok(percent(planted.clone().filter(|m| **m).count(), planted.count()))
}

fn percent(count: usize, of: usize) -> String {
    format!("{:.1} %", 100.0 * count as f64 / of as f64)
}
