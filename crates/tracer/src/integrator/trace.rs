//! Tracing a sample map onto a film.

use glam::Vec2;
use rayon::prelude::*;
use stack::{Cancelled, Knobs, Monitor, SampleMap, place};

use super::caustic::{Caustics, PassPhotons, Photons};
use super::path::PathTracer;
use super::{TraceError, TraceSettings, passes};
use crate::camera::{Camera, CameraRays};
use crate::film::{Film, SampleRecord, Tile, TileSums};
use crate::sampler::{self, Decision, Sampler, Stream};
use crate::scene::Scene;

/// What tracing took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraceReport {
    /// Samples that are on the film now.
    pub samples: u64,
    /// Rays cast for them, those for visibility included.
    pub rays: u64,
    /// Samples among them with a NaN or infinite value, which counts as zero.
    pub not_finite: u64,
}

impl TraceReport {
    /// This and `other` together.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self {
            samples: self.samples + other.samples,
            rays: self.rays + other.rays,
            not_finite: self.not_finite + other.not_finite,
        }
    }
}

/// Takes the samples that `map` asks for and adds them to `film`.
///
/// A pixel's filter is the box of the pixel itself. Samples depend on seed, film coordinates of the pixel and sample
/// number only, and are added in a fixed order: a crop equals that part of the whole, and any thread count gives the
/// same bytes. Work is done in passes of at most 8 samples per pixel; `monitor` hears of samples.
///
/// # Errors
/// When settings, film and map do not fit together, and with the report so far when `monitor` cancels. Then the film
/// holds all passes that were finished, and nothing of the one that was not.
pub fn trace(
    scene: &Scene,
    camera: &Camera,
    film: &mut Film,
    map: &SampleMap,
    settings: &TraceSettings,
    monitor: &dyn Monitor,
) -> Result<TraceReport, TraceError> {
    check(film, map, settings)?;
    monitor.begin("trace", map.samples());
    let work = Work {
        paths: PathTracer::new(scene, settings),
        rays: camera.rays(),
        sampler: Sampler::new(settings.seed),
        corner: [film.window().x, film.window().y],
        map,
        settings,
    };
    let caustics = Caustics::of(scene, settings, camera.pixel_width());
    let tiles = Tile::all(film.window().size);
    let mut report = TraceReport::default();
    for pass in 0..passes::count(map) {
        let (lights, before) = (&work.paths.lights, film.samples_before());
        let sent = caustics.as_ref().map(|caustics| caustics.send(lights, before, &work.samples_by_bucket(pass)));
        let (photons, rays) = sent.unzip();
        let traced = work.trace_pass(&tiles, pass, photons.as_ref(), monitor);
        let traced = traced.map_err(|Cancelled| TraceError::Cancelled(report))?;
        let (mut sums, reports): (Vec<_>, Vec<_>) = traced.into_iter().unzip();
        film.add_pass(&mut sums);
        report = reports.into_iter().fold(report, TraceReport::plus);
        report.rays += rays.unwrap_or(0);
    }
    Ok(report)
}

/// Checks that film, map and settings fit together.
fn check(film: &Film, map: &SampleMap, settings: &TraceSettings) -> Result<(), TraceError> {
    settings.validate()?;
    let TraceSettings { sequences, buckets, .. } = *settings;
    if buckets % sequences != 0 {
        return Err(TraceError::UnevenBuckets { buckets, sequences });
    }
    if film.dealing() != [sequences, buckets] {
        return Err(TraceError::OtherDealing { film: film.dealing(), settings: [sequences, buckets] });
    }
    let size = film.window().size;
    if let Some(found) = [map.first.len(), map.count.len()].into_iter().find(|n| *n != size.pixels()) {
        return Err(TraceError::MapSize { expected: size.pixels(), found });
    }
    let next = film.next_samples(0).first;
    for pixel in (0..size.pixels()).filter(|p| map.count[*p] > 0) {
        if map.first[pixel] != next[pixel] {
            let (x, y) = (pixel % size.width, pixel / size.width);
            return Err(TraceError::NotNext { x, y, expected: next[pixel], found: map.first[pixel] });
        }
        sampler::check_length(u64::from(map.first[pixel]) + u64::from(map.count[pixel]), sequences)?;
    }
    Ok(())
}

/// Everything a tile needs to know.
struct Work<'a> {
    paths: PathTracer<'a>,
    rays: CameraRays<'a>,
    sampler: Sampler,
    /// Film coordinates of the window's top left pixel.
    corner: [i32; 2],
    map: &'a SampleMap,
    settings: &'a TraceSettings,
}

impl Work<'_> {
    /// How many samples of the pass belong to each bucket.
    fn samples_by_bucket(&self, pass: u32) -> Vec<u64> {
        let TraceSettings { sequences, buckets, .. } = *self.settings;
        let mut samples = vec![0; buckets as usize];
        for index in (0..self.map.count.len()).flat_map(|pixel| passes::samples(self.map, pixel, pass)) {
            samples[place(index, sequences, buckets).bucket as usize] += 1;
        }
        samples
    }

    /// Sums of one pass, in the order of `tiles`, without those that have nothing to do.
    fn trace_pass(
        &self,
        tiles: &[Tile],
        pass: u32,
        photons: Option<&PassPhotons>,
        monitor: &dyn Monitor,
    ) -> Result<Vec<(TileSums, TraceReport)>, Cancelled> {
        let has_work = |tile: &Tile| tile.pixels().any(|(_, _, p)| !passes::samples(self.map, p, pass).is_empty());
        let trace_tile = |tile: &Tile| {
            if monitor.cancelled() {
                return Err(Cancelled);
            }
            let (sums, report) = self.trace_tile(tile, pass, photons);
            monitor.advance(report.samples);
            Ok((sums, report))
        };
        tiles.par_iter().filter(|tile| has_work(tile)).map(trace_tile).collect()
    }

    fn trace_tile(&self, tile: &Tile, pass: u32, photons: Option<&PassPhotons>) -> (TileSums, TraceReport) {
        let samples = tile.pixels().map(|(_, _, pixel)| passes::samples(self.map, pixel, pass).len()).sum();
        let mut sums = TileSums::new(tile.clone(), self.settings.buckets, samples);
        let mut report = TraceReport::default();
        for (i, (x, y, pixel)) in tile.pixels().enumerate() {
            let on_film = [self.corner[0] + x as i32, self.corner[1] + y as i32];
            for index in passes::samples(self.map, pixel, pass) {
                let at = place(index, self.settings.sequences, self.settings.buckets);
                let photons = photons.map(|photons| photons.of(at.bucket, index));
                let (mut record, rays) =
                    self.sample_pixel(on_film, &self.sampler.stream(on_film, at), photons.as_ref());
                let not_finite = u64::from(record.make_finite());
                report = report.plus(TraceReport { samples: 1, rays, not_finite });
                sums.add(i, at.bucket, &record);
            }
        }
        (sums, report)
    }

    /// One sample of the film's pixel in column `pixel[0]`, row `pixel[1]`.
    fn sample_pixel(&self, pixel: [i32; 2], stream: &Stream, photons: Option<&Photons>) -> (SampleRecord, u64) {
        let on_film = Vec2::new(pixel[0] as f32, pixel[1] as f32) + stream.sample_2d(Decision::FILM);
        let lens = stream.sample_2d(Decision::LENS);
        let ray = self.rays.ray(on_film, lens, stream.sample_1d(Decision::TIME));
        self.paths.follow(ray, stream, photons)
    }
}

#[cfg(test)]
mod tests {
    use stack::{Fault, Silent, Size, Window};

    use super::*;
    use crate::integrator::test_scenes::{furnace, looking_down};

    fn attempt(map: &SampleMap, settings: &TraceSettings) -> TraceError {
        let scene = furnace(0.5);
        let size = Size::new(4, 3);
        let mut film = Film::new(Window::whole(size), size, &TraceSettings::DEFAULT);
        trace(&scene, &looking_down(size), &mut film, map, settings, &Silent).unwrap_err()
    }

    #[test]
    fn what_does_not_fit_together_is_refused() {
        let defaults = TraceSettings::DEFAULT;
        let map = SampleMap::uniform(12, 0, 4);
        let uneven = TraceSettings { sequences: 3, ..defaults };
        assert_eq!(attempt(&map, &uneven), TraceError::UnevenBuckets { buckets: 8, sequences: 3 });
        let other = TraceSettings { sequences: 2, ..defaults };
        assert_eq!(attempt(&map, &other), TraceError::OtherDealing { film: [8, 8], settings: [2, 8] });
        let none = TraceSettings { buckets: 0, ..defaults };
        assert!(matches!(attempt(&map, &none), TraceError::Setting(_)));
        assert_eq!(attempt(&SampleMap::uniform(11, 0, 4), &defaults), TraceError::MapSize { expected: 12, found: 11 });
        let mut gap = map;
        gap.first[7] = 9;
        let refused = attempt(&gap, &defaults);
        assert_eq!(refused, TraceError::NotNext { x: 3, y: 1, expected: 0, found: 9 });
        assert_eq!(refused.fault(), Fault::Usage);
        assert!(matches!(attempt(&SampleMap::uniform(12, 0, u32::MAX), &defaults), TraceError::TooManySamples(_)));
    }
}
