//! Dimensionality reduction of the features in a window (section 4.3): the directions in which they really vary.

use pulp::Simd;

use super::field::Field;
use super::lanes::{Lanes, MOST_LANES};
use super::robust_pca::{Lambda, Order, RobustPca, Schedule};
use super::window::{Normalisation, Origin, Window};

stack::knob_choice! {
    /// How the low-rank part of the window's feature matrix is found.
    pub enum ReductionMethod {
        /// Robust principal component analysis.
        RobustPca = "rpca",
        /// Plain singular value decomposition; the rank then follows from the energy rule alone.
        Svd = "svd",
    }
}

stack::knob_choice! {
    /// Which of the two rules says how many directions are kept.
    pub enum RankRule {
        /// The larger of both.
        Larger = "max",
        /// k₁ of eq. 12: a share of the singular values' sum.
        Energy = "energy",
        /// k₂: singular values above a multiple of ‖E‖₂ (figure 8's OUR2).
        Perturbation = "perturbation",
    }
}

stack::knob_choice! {
    /// What eq. 12 sums.
    pub enum Energy {
        /// Singular values, as its text says.
        Values = "values",
        /// Their squares.
        Squares = "squares",
    }
}

stack::knobs! {
    /// Dimensionality reduction (section 4.3).
    pub struct ReductionSettings("reduce") {
        /// `rpca` (eq. 9) or `svd`.
        method: ReductionMethod = ReductionMethod::RobustPca, ..;
        /// At most this many iterations of robust PCA.
        iterations: usize = 10, 1..=50;
        /// Robust PCA stops when ‖D − A − E‖/‖D‖ falls below this.
        tolerance: f32 = 1e-3, 0.0..=1.0;
        /// `e-first` or `a-first`: what an iteration updates first.
        order: Order = Order::SparseFirst, ..;
        /// Weight λ of the sparse part for n neighbours and d features: `longest-side` 1/√max(n, d), `three-over-root`
        /// 3/√n, `shortest-side` 1/√d.
        lambda: Lambda = Lambda::LongestSide, ..;
        /// The reduction looks at every second (third, …) neighbour in x and y only. Windows of 11 × 11 pixels and
        /// less are always used whole.
        stride: usize = 2, 1..=4;
        /// Directions are kept until they hold this share of the energy (eq. 12).
        energy: f32 = 0.97, 0.0..=1.0;
        /// Energy is the sum of singular `values` (eq. 12) or of their `squares`.
        energy_of: Energy = Energy::Values, ..;
        /// Directions with σ > C‖E‖₂ are kept; this is C (section 4.3, after Moon et al. 2014).
        perturbation: f32 = 4.0, 0.0..=100.0;
        /// Which rule decides: `max`, `energy` or `perturbation`.
        rank: RankRule = RankRule::Larger, ..;
    }
}

/// At least this many directions are kept, if there are so many.
const LEAST_RANK: usize = 2;
/// A direction exists when its singular value is more than this times the largest: the rest is rounding.
const EXISTS: f32 = 1e-3;
/// Windows of at most this radius are not thinned.
const WHOLE_RADIUS: usize = 5;

/// The reduced space of the pixels worked on side by side, and the room to find it in.
#[derive(Debug)]
pub(crate) struct Reduction<S: Simd> {
    simd: S,
    /// Features that vary in the window of at least one of the pixels.
    pub(crate) listed: Vec<usize>,
    /// Numbers per row of unscaled differences: `listed.len()`, rounded up to an even number, at least 2.
    pub(crate) width: usize,
    /// Scaled V_k: `width` rows of `columns` numbers. Its product with unscaled x_i − x_c is z_i.
    pub(crate) basis: Vec<Lanes<S>>,
    /// Numbers per row of `basis`: the largest rank, rounded up to an even number, at least 2.
    pub(crate) columns: usize,
    /// Rank k of each pixel.
    pub(crate) rank: [usize; MOST_LANES],
    /// The largest of them.
    pub(crate) largest_rank: usize,
    pca: RobustPca<S>,
    found: Vec<Direction>,
    /// For each lane, the indices of its singular vectors, the strongest first.
    kept: Vec<usize>,
    vectors: Vec<f32>,
}

/// Which directions a truncated decomposition keeps: those with σ > `thin` + C‖E‖₂, at least two.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truncation {
    /// Neighbours from one that is looked at to the next, in x and y.
    pub(crate) stride: usize,
    /// Keeps empty directions out where there is no noise.
    pub(crate) thin: f32,
    /// C.
    pub(crate) perturbation: f32,
}

/// A candidate direction of one pixel.
#[derive(Clone, Copy, Debug)]
struct Direction {
    /// Which of the singular vectors.
    index: usize,
    /// Its singular value in A.
    singular: f32,
    /// Its singular value before shrinking.
    strength: f32,
}

impl<S: Simd> Reduction<S> {
    /// Room for the windows of `field`.
    pub(crate) fn new(simd: S, field: &Field) -> Self {
        let width = field.features.next_multiple_of(2).max(2);
        Self {
            simd,
            listed: Vec::with_capacity(field.features),
            width,
            basis: vec![Lanes::splat(simd, 0.0); width * width],
            columns: 2,
            rank: [0; MOST_LANES],
            largest_rank: 0,
            pca: RobustPca::with_capacity(simd, (2 * field.radius + 1).pow(2), width),
            found: Vec::with_capacity(width),
            kept: vec![0; width * MOST_LANES],
            vectors: vec![0.0; width * width * Lanes::<S>::COUNT],
        }
    }

    /// Finds rank and basis for the pixels of `window`, and the window's scales on the way.
    #[inline(always)]
    pub(crate) fn find(
        &mut self,
        field: &Field,
        window: &mut Window<S>,
        normalisation: Normalisation,
        settings: &ReductionSettings,
    ) {
        window.normalise(field, normalisation);
        self.list_features(window);
        if self.listed.is_empty() {
            self.rank = [0; MOST_LANES];
        } else {
            self.decompose(field, window, settings);
            self.choose_ranks(settings);
        }
        self.fill_basis(window);
    }

    /// Finds rank and basis by the truncated singular value decomposition of Moon et al. 2014, section 4, of the
    /// features about their mean. `error` gives ‖E‖_F², expected from the features' own variances, once the window's
    /// scales are known; ‖E‖₂ is taken for ‖E‖_F over the root of the number of directions, as their program does.
    #[inline(always)]
    pub(crate) fn truncate(
        &mut self,
        field: &Field,
        window: &mut Window<S>,
        how: Truncation,
        error: impl Fn(&Window<S>, Lanes<S>) -> Lanes<S>,
    ) {
        window.normalise(field, Normalisation::Window);
        self.list_features(window);
        self.rank = [0; MOST_LANES];
        if !self.listed.is_empty() {
            let step = if field.radius > WHOLE_RADIUS { how.stride } else { 1 };
            let shape = (step, Origin::Mean);
            let rows = window.lattice(field, shape, &self.listed, self.width, &mut self.pca.data);
            self.pca.keep_all(self.width, &self.listed, field.features);
            let errors = error(window, rows).to_array();
            for lane in 0..Lanes::<S>::COUNT {
                self.sort_directions(lane);
                self.rank[lane] = truncated_rank(&self.found, errors[lane], how);
            }
        }
        self.fill_basis(window);
    }

    #[inline(always)]
    fn list_features(&mut self, window: &Window<S>) {
        let zero = Lanes::splat(self.simd, 0.0);
        self.listed.clear();
        for (feature, scale) in window.scales.iter().enumerate() {
            if zero.less_than(*scale).any() {
                self.listed.push(feature);
            }
        }
        self.width = self.listed.len().next_multiple_of(2).max(2);
    }

    #[inline(always)]
    fn decompose(&mut self, field: &Field, window: &Window<S>, settings: &ReductionSettings) {
        let step = if field.radius > WHOLE_RADIUS { settings.stride } else { 1 };
        let (width, all) = (self.width, field.features);
        let rows = window.lattice(field, (step, Origin::Pixel), &self.listed, width, &mut self.pca.data);
        match settings.method {
            ReductionMethod::Svd => self.pca.keep_all(width, &self.listed, all),
            ReductionMethod::RobustPca => {
                let ReductionSettings { iterations, tolerance, order, lambda, .. } = *settings;
                let schedule = Schedule { iterations, tolerance, order, lambda };
                self.pca.decompose(width, &self.listed, all, rows, schedule);
            }
        }
    }

    /// Chooses each pixel's rank and which singular vectors it keeps, the strongest first.
    #[inline(always)]
    fn choose_ranks(&mut self, settings: &ReductionSettings) {
        let error_norms = self.pca.error_norm.to_array();
        for lane in 0..Lanes::<S>::COUNT {
            self.sort_directions(lane);
            self.rank[lane] = rank_of(&self.found, error_norms[lane], settings);
        }
    }

    /// Sorts the singular vectors of a pixel, the strongest first.
    #[inline(always)]
    fn sort_directions(&mut self, lane: usize) {
        self.found.clear();
        for index in 0..self.width {
            let singular = self.pca.singular[index].to_array()[lane];
            let strength = self.pca.strengths[index].to_array()[lane];
            self.found.push(Direction { index, singular, strength });
        }
        self.found.sort_unstable_by(|a, b| b.strength.total_cmp(&a.strength));
        for (place, direction) in self.found.iter().enumerate() {
            self.kept[lane * self.width + place] = direction.index;
        }
    }

    /// Puts V_k together, scaled, from each pixel's own choice of singular vectors.
    #[inline(always)]
    fn fill_basis(&mut self, window: &Window<S>) {
        self.largest_rank = self.rank.iter().copied().max().unwrap_or(0);
        self.columns = self.largest_rank.next_multiple_of(2).max(2);
        let (lanes, width) = (Lanes::<S>::COUNT, self.width);
        for (i, vector) in self.pca.vectors[..width * width].iter().enumerate() {
            vector.store(&mut self.vectors[i * lanes..]);
        }
        self.basis.fill(Lanes::splat(self.simd, 0.0));
        for place in 0..self.columns {
            for (i, feature) in self.listed.iter().enumerate() {
                let mut values = [0.0; MOST_LANES];
                for lane in (0..lanes).filter(|lane| place < self.rank[*lane]) {
                    values[lane] = self.vectors[(self.kept[lane * width + place] * width + i) * lanes + lane];
                }
                self.basis[i * self.columns + place] = Lanes::load(self.simd, &values) * window.scales[*feature];
            }
        }
    }
}

/// Rank after truncation, see [`Reduction::truncate`]; `error` is ‖E‖_F².
fn truncated_rank(directions: &[Direction], error: f32, how: Truncation) -> usize {
    let existing = existing(directions);
    let norm = (error / existing.max(1) as f32).sqrt();
    let kept = directions.iter().take_while(|d| d.strength > how.thin + how.perturbation * norm).count();
    kept.max(LEAST_RANK).min(existing)
}

/// Rank k from the `directions` of a pixel, strongest first (section 4.3).
fn rank_of(directions: &[Direction], error_norm: f32, settings: &ReductionSettings) -> usize {
    let by_energy = rank_by_energy(directions, settings);
    let by_perturbation = match settings.method {
        ReductionMethod::Svd => 0,
        ReductionMethod::RobustPca => {
            directions.iter().take_while(|d| d.singular > settings.perturbation * error_norm).count()
        }
    };
    let chosen = match settings.rank {
        RankRule::Larger => by_energy.max(by_perturbation),
        RankRule::Energy => by_energy,
        RankRule::Perturbation => by_perturbation,
    };
    chosen.max(LEAST_RANK).min(existing(directions))
}

/// How many `directions` are more than rounding.
fn existing(directions: &[Direction]) -> usize {
    let strongest = directions.first().map_or(0.0, |d| d.strength);
    directions.iter().take_while(|d| d.strength > EXISTS * strongest).count()
}

/// Smallest k₁ whose first singular values hold the wanted share of the energy (eq. 12); 0 when there is none.
fn rank_by_energy(directions: &[Direction], settings: &ReductionSettings) -> usize {
    let energy = |d: &Direction| match settings.energy_of {
        Energy::Values => d.singular,
        Energy::Squares => d.singular * d.singular,
    };
    let total: f32 = directions.iter().map(energy).sum();
    let mut sum = 0.0;
    for (k, direction) in directions.iter().enumerate() {
        if sum > settings.energy * total || energy(direction) == 0.0 {
            return k;
        }
        sum += energy(direction);
    }
    directions.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions(singular: &[f32]) -> Vec<Direction> {
        singular.iter().enumerate().map(|(index, s)| Direction { index, singular: *s, strength: s + 0.01 }).collect()
    }

    fn settings(rank: RankRule) -> ReductionSettings {
        ReductionSettings { rank, ..ReductionSettings::DEFAULT }
    }

    #[test]
    fn ranks_by_hand() {
        let found = directions(&[6.0, 2.0, 1.5, 0.3, 0.2, 0.0]);
        // 9.5 of 10 after three values, 9.8 after four.
        assert_eq!(rank_of(&found, 10.0, &settings(RankRule::Energy)), 4);
        assert_eq!(rank_of(&found, 0.06, &settings(RankRule::Perturbation)), 4);
        assert_eq!(rank_of(&found, 0.04, &settings(RankRule::Perturbation)), 5);
        assert_eq!(rank_of(&found, 0.04, &settings(RankRule::Larger)), 5);
        assert_eq!(rank_of(&found, 10.0, &settings(RankRule::Larger)), 4);
        // Squares: 36, 4, 2.25, …: 40 of 42.38 after two, 42.25 after three.
        let squares = ReductionSettings { energy_of: Energy::Squares, ..settings(RankRule::Energy) };
        assert_eq!(rank_of(&found, 10.0, &squares), 3);
    }

    #[test]
    fn at_least_two_directions_where_they_exist() {
        assert_eq!(rank_of(&directions(&[5.0, 0.0, 0.0]), 10.0, &settings(RankRule::Perturbation)), 2);
        let mut one = directions(&[5.0, 0.0]);
        one[1].strength = 0.0;
        assert_eq!(rank_of(&one, 0.0, &settings(RankRule::Larger)), 1);
        one[0] = Direction { index: 0, singular: 0.0, strength: 0.0 };
        assert_eq!(rank_of(&one, 0.0, &settings(RankRule::Larger)), 0);
    }

    #[test]
    fn truncation_drops_what_the_features_own_noise_explains() {
        let found = directions(&[6.0, 2.0, 1.5, 0.3, 0.2]);
        let rank = |error| truncated_rank(&found, error, Truncation { stride: 1, thin: 0.01, perturbation: 4.0 });
        // ‖E‖₂ is √(0.8/5) = 0.4: four times that lies between the second and the third.
        assert_eq!([0.8, 0.2, 0.0, 100.0].map(rank), [2, 3, 5, 2]);
    }

    #[test]
    fn plain_decompositions_follow_the_energy_alone() {
        let svd = ReductionSettings { method: ReductionMethod::Svd, ..ReductionSettings::DEFAULT };
        assert_eq!(rank_of(&directions(&[6.0, 2.0, 1.5, 0.3, 0.2]), 0.0, &svd), 4);
    }
}
