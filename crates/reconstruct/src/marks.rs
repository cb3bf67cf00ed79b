//! Sets of pixels, as one mark each.

use rayon::prelude::*;
use stack::Size;

/// The pixels that have one of `marks` at most `radius` away, in rows and in columns.
pub fn grown(marks: &[bool], size: Size, radius: usize) -> Vec<bool> {
    let mut wide = vec![false; marks.len()];
    wide.par_chunks_mut(size.width).zip(marks.par_chunks(size.width)).for_each(|(wide, marks)| {
        for (x, _) in marks.iter().enumerate().filter(|(_, mark)| **mark) {
            wide[x.saturating_sub(radius)..(x + radius + 1).min(size.width)].fill(true);
        }
    });
    let mut grown = vec![false; marks.len()];
    grown.par_chunks_mut(size.width).enumerate().for_each(|(y, grown)| {
        let rows = y.saturating_sub(radius)..(y + radius + 1).min(size.height);
        for row in wide[rows.start * size.width..rows.end * size.width].chunks(size.width) {
            grown.iter_mut().zip(row).for_each(|(grown, mark)| *grown |= mark);
        }
    });
    grown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_grows_to_a_square_that_ends_at_the_border() {
        let size = Size::new(9, 6);
        let mut marks = vec![false; size.pixels()];
        marks[size.index(1, 3)] = true;
        let grown = grown(&marks, size, 2);
        for pixel in 0..size.pixels() {
            let inside = pixel % 9 <= 3 && (1..=5).contains(&(pixel / 9));
            assert_eq!(grown[pixel], inside, "{} {}", pixel % 9, pixel / 9);
        }
        assert_eq!(super::grown(&marks, size, 0), marks);
    }
}
