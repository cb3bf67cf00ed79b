//! The patch-based propagation filter (the paper's section 4.2, after Chang and Wang 2015).
//!
//! The weight of q at c follows its path: log w(c,q) = log w(c,p) − D(P(p),P(q)) − D(P(c),P(q)), where p precedes q.
//! Each distance is needed for all pixels at once and depends on an offset only, so that a tile takes one distance image
//! per offset for D(P(c),P(q)) and four in all for the adjacent pairs D(P(p),P(q)).

use stack::{Cancelled, Monitor};

use super::paths::{NEIGHBOURS, Step, steps};
use crate::exp::exp_of_negative;
use crate::patch_distance::{NoisyPlanes, PatchComparison, PatchDistance};
use crate::pieces::of_each;
use crate::rectangle::{Rectangle, put_together, tiles_of};

/// Side of the tiles that are filtered one by one: their buffers stay in a core's own cache.
const TILE: usize = 64;

/// Shape of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Manhattan radius r of the pattern.
    pub radius: usize,
    /// Radius of the patches; 0 is the pixel-based filter.
    pub patch_radius: usize,
    /// ε of eq. 10.
    pub epsilon: f32,
}

/// How many tiles [`propagation_filter`] will report.
pub fn tile_count(size: stack::Size) -> usize {
    size.width.div_ceil(TILE) * size.height.div_ceil(TILE)
}

/// Filters all channels of one feature group with the same weights. Values are used as they are: nothing may be NaN.
///
/// # Errors
/// When the monitor cancels.
pub fn propagation_filter(
    planes: NoisyPlanes,
    shape: Shape,
    monitor: &dyn Monitor,
) -> Result<Vec<Vec<f32>>, Cancelled> {
    let steps = steps(shape.radius);
    let tiles = tiles_of(planes.size, TILE);
    let filtered = of_each(&tiles, monitor, |tile| TileFilter::new(planes, shape, *tile).run(&steps))?;
    Ok(put_together(planes.size, &tiles, &filtered, planes.values.len()))
}

/// Filters one tile.
struct TileFilter<'a> {
    planes: NoisyPlanes<'a>,
    tile: Rectangle,
    distance: PatchDistance<'a>,
    /// D(P(c), P(q)) for the offset at hand.
    to_centre: Vec<f32>,
    /// D(P(p), P(p + step)) for each of the four steps, over every pixel p that paths from this tile may cross.
    adjacent: [Vec<f32>; 4],
    crossed: Rectangle,
    /// log w of the pixels of the current path, by depth.
    log_weights: Vec<Vec<f32>>,
    weights: Vec<f32>,
    /// Σ w y, per channel.
    sums: Vec<Vec<f32>>,
}

impl<'a> TileFilter<'a> {
    fn new(planes: NoisyPlanes<'a>, shape: Shape, tile: Rectangle) -> Self {
        let pixels = tile.width() * tile.height();
        let comparison =
            PatchComparison { patch_radius: shape.patch_radius, epsilon: shape.epsilon, noise_taken_off: 1.0 };
        let crossed = tile.grown(shape.radius.saturating_sub(1), planes.size);
        Self {
            planes,
            tile,
            distance: PatchDistance::new(planes, comparison),
            to_centre: Vec::new(),
            adjacent: Default::default(),
            crossed,
            log_weights: vec![vec![0.0; pixels]; shape.radius + 1],
            weights: vec![1.0; pixels],
            sums: planes.values.iter().map(|plane| cut_out(plane, planes, tile)).collect(),
        }
    }

    /// Weighted means, one plane of the tile's size per channel.
    fn run(mut self, steps: &[Step]) -> Vec<Vec<f32>> {
        for (direction, step) in NEIGHBOURS.into_iter().enumerate() {
            let centres = self.crossed.where_inside(step, self.planes.size);
            self.distance.compute(centres, step, &mut self.adjacent[direction]);
        }
        for step in steps {
            self.take(step);
        }
        for sums in &mut self.sums {
            for (sum, weight) in sums.iter_mut().zip(&self.weights) {
                *sum /= weight;
            }
        }
        self.sums
    }

    /// Adds the pixel at one offset to the means of all pixels that have one there.
    fn take(&mut self, step: &Step) {
        let centres = self.tile.where_inside(step.offset, self.planes.size);
        if centres.width() == 0 || centres.height() == 0 {
            return;
        }
        self.distance.compute(centres, step.offset, &mut self.to_centre);
        for y in centres.y0..centres.y1 {
            self.extend_paths(step, centres, y);
            self.accumulate(step, centres, y);
        }
    }

    /// log w(c,q) for one row of centres.
    fn extend_paths(&mut self, step: &Step, centres: Rectangle, y: usize) {
        let crossed = self.crossed.where_inside(NEIGHBOURS[step.direction], self.planes.size);
        let parent_x = centres.x0.wrapping_add_signed(step.parent[0]) - crossed.x0;
        let parent_y = y.wrapping_add_signed(step.parent[1]) - crossed.y0;
        let (width, at) = (centres.width(), index_in(self.tile, centres.x0, y));
        let to_parent = &self.adjacent[step.direction][parent_x + parent_y * crossed.width()..][..width];
        let to_centre = &self.to_centre[(y - centres.y0) * width..][..width];
        let (before, after) = self.log_weights.split_at_mut(step.depth);
        let parents = &before[step.depth - 1][at..][..width];
        let own = &mut after[0][at..][..width];
        for i in 0..width {
            own[i] = parents[i] - to_parent[i] - to_centre[i];
        }
    }

    /// Adds w and w·y for one row of centres.
    fn accumulate(&mut self, step: &Step, centres: Rectangle, y: usize) {
        let (width, at) = (centres.width(), index_in(self.tile, centres.x0, y));
        let weight = &mut self.to_centre[(y - centres.y0) * width..][..width];
        for (w, log) in weight.iter_mut().zip(&self.log_weights[step.depth][at..][..width]) {
            *w = exp_of_negative(*log);
        }
        for (total, w) in self.weights[at..][..width].iter_mut().zip(&*weight) {
            *total += w;
        }
        let [dx, dy] = step.offset;
        let q = self.planes.size.index(centres.x0.wrapping_add_signed(dx), y.wrapping_add_signed(dy));
        for (sums, plane) in self.sums.iter_mut().zip(self.planes.values) {
            let (sums, values) = (&mut sums[at..][..width], &plane[q..][..width]);
            for i in 0..width {
                sums[i] += weight[i] * values[i];
            }
        }
    }
}

/// Index of pixel (x, y) in a plane that covers `tile` only.
fn index_in(tile: Rectangle, x: usize, y: usize) -> usize {
    (x - tile.x0) + (y - tile.y0) * tile.width()
}

fn cut_out(plane: &[f32], planes: NoisyPlanes, tile: Rectangle) -> Vec<f32> {
    (tile.y0..tile.y1).flat_map(|y| &plane[planes.size.index(tile.x0, y)..][..tile.width()]).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch_distance::tests::{distance_twin, random_planes};
    use crate::test_noise::TestNoise;
    use stack::{Silent, Size};

    const PAPER: Shape = Shape { radius: 5, patch_radius: 3, epsilon: 1e-4 };

    /// The filter as the paper states it: walks every path of every pixel.
    fn twin(planes: NoisyPlanes, shape: Shape) -> Vec<Vec<f64>> {
        let (w, h) = (planes.size.width as isize, planes.size.height as isize);
        let Shape { patch_radius, epsilon, .. } = shape;
        let d = |a, b| distance_twin(planes, a, b, PatchComparison { patch_radius, epsilon, noise_taken_off: 1.0 });
        let mut out = vec![Vec::new(); planes.values.len()];
        for c in (0..h).flat_map(|y| (0..w).map(move |x| [x, y])) {
            let r = shape.radius as isize;
            let (mut total, mut sums) = (0.0, vec![0.0; out.len()]);
            for (dx, dy) in (-r..=r).flat_map(|dy| (-r..=r).map(move |dx| (dx, dy))) {
                let q = [c[0] + dx, c[1] + dy];
                if dx.abs() + dy.abs() > r || !(0..w).contains(&q[0]) || !(0..h).contains(&q[1]) {
                    continue;
                }
                let (mut log, mut at) = (0.0, q);
                while at != c {
                    let (x, y) = (at[0] - c[0], at[1] - c[1]);
                    let vertical = if x == 0 || y == 0 { x == 0 } else { (x.abs() + y.abs()) % 2 == 1 };
                    let before = if vertical { [at[0], at[1] - y.signum()] } else { [at[0] - x.signum(), at[1]] };
                    log -= d(before, at) + d(c, at);
                    at = before;
                }
                total += f64::exp(log);
                for (sum, plane) in sums.iter_mut().zip(planes.values) {
                    *sum += f64::exp(log) * f64::from(plane[(q[0] + q[1] * w) as usize]);
                }
            }
            out.iter_mut().zip(&sums).for_each(|(plane, sum)| plane.push(sum / total));
        }
        out
    }

    #[test]
    fn agrees_with_a_filter_that_walks_every_path() {
        for (size, channels) in
            [(Size::new(19, 14), 3), (Size::new(70, 9), 1), (Size::new(1, 1), 2), (Size::new(3, 2), 1)]
        {
            let [values, variances] = random_planes(size, channels, 8);
            let planes = NoisyPlanes { size, values: &values, variances: &variances };
            for shape in
                [PAPER, Shape { patch_radius: 0, ..PAPER }, Shape { radius: 2, patch_radius: 1, epsilon: 1e-3 }]
            {
                let fast = propagation_filter(planes, shape, &Silent).unwrap();
                for (fast, slow) in fast.iter().zip(twin(planes, shape)) {
                    for (a, b) in fast.iter().zip(slow) {
                        assert!((f64::from(*a) - b).abs() < 2e-5, "{a} {b} at {size} {shape:?}");
                    }
                }
            }
        }
    }

    /// A step between −0.5 and 0.5 with noise of deviation σ, and its smoothed variance.
    fn noisy_step(size: Size, sigma: f32) -> (Vec<f32>, Vec<f32>) {
        let mut noise = TestNoise(4);
        let step = |i: usize| if i % size.width < size.width / 2 { -0.5 } else { 0.5 };
        let values = (0..size.pixels()).map(|i| step(i) + sigma * noise.normal() as f32).collect();
        (values, vec![sigma * sigma; size.pixels()])
    }

    #[test]
    fn noise_shrinks_and_an_edge_survives() {
        let size = Size::new(80, 40);
        let (values, variance) = noisy_step(size, 0.1);
        let (values, variances) = (vec![values], vec![variance]);
        let planes = NoisyPlanes { size, values: &values, variances: &variances };
        let filtered = &propagation_filter(planes, PAPER, &Silent).unwrap()[0];
        let truth = |i: usize| if i % 80 < 40 { -0.5 } else { 0.5 };
        let squares = |plane: &[f32], keep: &dyn Fn(usize) -> bool| {
            let errors: Vec<f32> = (0..3200).filter(|i| keep(*i)).map(|i| (plane[i] - truth(i)).powi(2)).collect();
            errors.iter().sum::<f32>() / errors.len() as f32
        };
        let beside_edge = |i: usize| (38..42).contains(&(i % 80));
        assert!(squares(filtered, &|i| !beside_edge(i)) < 0.1 * squares(&values[0], &|i| !beside_edge(i)));
        assert!(squares(filtered, &beside_edge) < squares(&values[0], &beside_edge), "noise, and no blur, is left");
    }

    #[test]
    fn what_has_no_noise_passes() {
        let size = Size::new(30, 20);
        let (values, _) = noisy_step(size, 0.0);
        let (values, variances) = (vec![values], vec![vec![0.0; 600]]);
        let planes = NoisyPlanes { size, values: &values, variances: &variances };
        let filtered = propagation_filter(planes, PAPER, &Silent).unwrap();
        assert!(filtered[0].iter().zip(&values[0]).all(|(a, b)| (a - b).abs() < 1e-6));
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let size = Size::new(150, 130);
        let [values, variances] = random_planes(size, 1, 8);
        let planes = NoisyPlanes { size, values: &values, variances: &variances };
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| propagation_filter(planes, PAPER, &Silent).unwrap())
        };
        assert_eq!(run(1), run(3));
    }
}
