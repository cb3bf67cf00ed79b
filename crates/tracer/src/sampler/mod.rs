//! Random numbers of a path: Owen-scrambled Sobol points, a pure function of seed, pixel, sample and decision.
//!
//! Every decision of a path (where on the lens, which light, which direction …) takes a fresh one- or two-dimensional
//! point set: the first one or two Sobol dimensions, freshly scrambled and with a freshly shuffled index ("padding",
//! Burley 2020, *Practical Hash-based Owen Scrambling*, section 4). Higher pairs of Sobol dimensions are badly
//! stratified and never used.
//!
//! Samples of a pixel are dealt to independently scrambled sequences by [`stack::place`], so that partial means are
//! independent and their spread measures the noise (see `docs/method.md`).

mod decision;
mod sobol;
pub mod warp;

#[cfg(test)]
mod independence_tests;

pub use decision::Decision;
use glam::Vec2;
use sobol::Scramble;
use sobol_burley::parts::u32_to_f32_norm;
use stack::{Fault, Place};

/// Points in a sequence. An `f32` takes 2²³ evenly spaced values in [0, 1): a longer sequence would repeat itself.
pub const SEQUENCE_LENGTH: u32 = 1 << 23;

/// More samples were asked for than a sequence holds points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "sample {sample} does not exist: {sequences} sequences of {SEQUENCE_LENGTH} points hold {} samples of a pixel; \
     ask for fewer samples or set more sequences",
    u64::from(*.sequences) * u64::from(SEQUENCE_LENGTH)
)]
pub struct SequenceTooShort {
    /// Number of the last sample that was asked for.
    pub sample: u64,
    /// How many sequences the samples are dealt to.
    pub sequences: u32,
}

impl SequenceTooShort {
    /// Whose fault it is.
    pub const fn fault(&self) -> Fault {
        Fault::Usage
    }
}

/// Checks that the samples before number `end` of a pixel exist when they are dealt to `sequences` sequences.
///
/// # Errors
/// When `end` lies past the sequences' last point.
pub fn check_length(end: u64, sequences: u32) -> Result<(), SequenceTooShort> {
    let held = (u64::from(sequences) * u64::from(SEQUENCE_LENGTH)).min(u64::from(u32::MAX));
    if end <= held { Ok(()) } else { Err(SequenceTooShort { sample: end - 1, sequences }) }
}

/// Makes the random numbers of every sample of a render.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    seed: u64,
}

impl Sampler {
    /// A sampler whose numbers all depend on `seed`; nearby seeds give unrelated numbers.
    pub fn new(seed: u64) -> Self {
        Self { seed: sobol::mix(seed) }
    }

    /// The random numbers of one sample: of the film's pixel in column `pixel[0]`, row `pixel[1]`, at `place` in the
    /// pixel's sequences.
    #[inline]
    pub fn stream(&self, pixel: [i32; 2], place: Place) -> Stream {
        let pixel = u64::from(pixel[0] as u32) | u64::from(pixel[1] as u32) << 32;
        let of_pixel = sobol::mix(self.seed ^ pixel);
        Stream { key: sobol::combine(of_pixel, place.sequence), point: place.point.reverse_bits() }
    }
}

/// The random numbers of one sample, by decision. Asking twice gives the same number twice.
#[derive(Clone, Copy, Debug)]
pub struct Stream {
    key: u64,
    /// Bits in reverse, as the scramble wants them.
    point: u32,
}

impl Stream {
    /// A number in [0, 1).
    #[inline]
    pub fn sample_1d(&self, decision: Decision) -> f32 {
        u32_to_f32_norm(self.sample_bits(decision))
    }

    /// A point in [0, 1)².
    #[inline]
    pub fn sample_2d(&self, decision: Decision) -> Vec2 {
        let scramble = Scramble::new(sobol::combine(self.key, decision.number()));
        let [x, y] = scramble.point_2d(self.point);
        Vec2::new(u32_to_f32_norm(x), u32_to_f32_norm(y))
    }

    /// A whole number, uniform over all 2³²: for choices among so many that an `f32` would favour some.
    #[inline]
    pub fn sample_bits(&self, decision: Decision) -> u32 {
        Scramble::new(sobol::combine(self.key, decision.number())).point_1d(self.point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_past_the_sequence_is_refused() {
        assert!(check_length(u64::from(SEQUENCE_LENGTH), 1).is_ok());
        let refused = check_length(u64::from(SEQUENCE_LENGTH) + 1, 1).unwrap_err();
        assert_eq!(refused, SequenceTooShort { sample: u64::from(SEQUENCE_LENGTH), sequences: 1 });
        assert!(refused.to_string().contains("hold 8388608 samples"));
        assert!(check_length(u64::from(SEQUENCE_LENGTH) + 1, 8).is_ok());
        assert!(check_length(1 << 40, 512).is_err());
    }

    #[test]
    fn numbers_depend_on_seed_pixel_sequence_point_and_decision() {
        let place = |sequence, point| Place { sequence, point, bucket: 0 };
        let number = |seed, pixel, at, decision| Sampler::new(seed).stream(pixel, at).sample_1d(decision);
        let all = [
            number(0, [0, 0], place(0, 0), Decision::TIME),
            number(1, [0, 0], place(0, 0), Decision::TIME),
            number(0, [1, 0], place(0, 0), Decision::TIME),
            number(0, [0, 1], place(0, 0), Decision::TIME),
            number(0, [-1, 0], place(0, 0), Decision::TIME),
            number(0, [0, 0], place(1, 0), Decision::TIME),
            number(0, [0, 0], place(0, 1), Decision::TIME),
            number(0, [0, 0], place(0, 0), Decision::roulette(0)),
        ];
        for i in 0..all.len() {
            for j in 0..i {
                assert_ne!(all[i], all[j], "{i} {j}");
            }
        }
    }
}
