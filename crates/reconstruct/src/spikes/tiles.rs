//! The image cut into tiles, each decomposed by itself (algorithm 1, lines 1–8).

use nalgebra::DMatrix;
use rayon::prelude::*;
use stack::{Cancelled, Image, Monitor, Size};

use super::alm::{AlmSettings, sparse_part};

/// E of every tile and channel of `image`, put together again: candidates for spikes. Tiles have `tile_size`² pixels,
/// less at the right and lower borders.
///
/// # Errors
/// When the monitor cancels.
pub fn sparse_layer(
    image: &Image,
    tile_size: usize,
    alm: &AlmSettings,
    monitor: &dyn Monitor,
) -> Result<Image, Cancelled> {
    let size = image.size();
    let rows_of_tiles = size.height.div_ceil(tile_size) * image.channels().len();
    monitor.begin("spikes", rows_of_tiles as u64);
    let mut sparse = Image::zeros(size, image.channels().len());
    let band = (tile_size * size.width).max(1);
    sparse.channels_mut().par_iter_mut().zip(image.channels()).try_for_each(|(out, plane)| {
        out.par_chunks_mut(band).zip(plane.par_chunks(band)).try_for_each(|(out, rows)| {
            if monitor.cancelled() {
                return Err(Cancelled);
            }
            decompose_row_of_tiles(rows, Size::new(size.width, rows.len() / size.width), tile_size, alm, out);
            monitor.advance(1);
            Ok(())
        })
    })?;
    Ok(sparse)
}

/// Decomposes the tiles that stand side by side in `rows`, `size` pixels of one channel.
fn decompose_row_of_tiles(rows: &[f32], size: Size, tile_size: usize, alm: &AlmSettings, out: &mut [f32]) {
    for left in (0..size.width).step_by(tile_size) {
        let width = tile_size.min(size.width - left);
        let tile = DMatrix::from_fn(size.height, width, |y, x| f64::from(rows[size.index(left + x, y)]));
        let sparse = sparse_part(&tile, alm);
        for y in 0..size.height {
            for x in 0..width {
                out[size.index(left + x, y)] = sparse[(y, x)] as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::TestNoise;
    use stack::Silent;

    #[test]
    fn tiles_at_the_border_are_smaller_and_stand_for_themselves() {
        let size = Size::new(13, 11);
        let mut noise = TestNoise(3);
        let planes = (0..3).map(|_| noise.normals(size.pixels(), 2.0, 1.0)).collect();
        let image = Image::from_channels(size, planes);
        let alm = AlmSettings { iterations: 3, ..AlmSettings::default() };
        let sparse = sparse_layer(&image, 8, &alm, &Silent).unwrap();
        for (left, top, width, height) in [(0, 0, 8, 8), (8, 0, 5, 8), (0, 8, 8, 3), (8, 8, 5, 3)] {
            for c in 0..3 {
                let at = |x, y| size.index(left + x, top + y);
                let tile = DMatrix::from_fn(height, width, |y, x| f64::from(image.channels()[c][at(x, y)]));
                let expected = sparse_part(&tile, &alm);
                for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    assert_eq!(sparse.channels()[c][at(x, y)], expected[(y, x)] as f32);
                }
            }
        }
    }

    #[test]
    fn stops_when_cancelled_and_accepts_an_empty_image() {
        struct Impatient;
        impl Monitor for Impatient {
            fn cancelled(&self) -> bool {
                true
            }
        }
        let image = Image::zeros(Size::new(4, 4), 3);
        assert_eq!(sparse_layer(&image, 8, &AlmSettings::default(), &Impatient), Err(Cancelled));
        let empty = Image::zeros(Size::new(0, 0), 3);
        assert_eq!(sparse_layer(&empty, 8, &AlmSettings::default(), &Silent), Ok(empty.clone()));
    }
}
