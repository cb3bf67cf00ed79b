//! Rectangles against what their words say of each pixel.

use super::*;

const SIZE: Size = Size::new(9, 7);
const PART: Rectangle = Rectangle { x0: 2, y0: 1, x1: 6, y1: 5 };

fn pixels(size: Size) -> impl Iterator<Item = (usize, usize)> {
    (0..size.pixels()).map(move |i| (i % size.width, i / size.width))
}

impl Rectangle {
    /// Whether it holds the pixel in column `x`, row `y`.
    fn contains(self, x: usize, y: usize) -> bool {
        (self.x0..self.x1).contains(&x) && (self.y0..self.y1).contains(&y)
    }
}

#[test]
fn tiles_cover_every_pixel_once() {
    for (size, side) in [(Size::new(1, 1), 16), (Size::new(7, 3), 1), (Size::new(9, 7), 3), (Size::new(64, 65), 64)] {
        let tiles = tiles_of(size, side);
        assert!(tiles.iter().all(|tile| (1..=side).contains(&tile.width()) && (1..=side).contains(&tile.height())));
        for (x, y) in pixels(size) {
            assert_eq!(tiles.iter().filter(|tile| tile.contains(x, y)).count(), 1, "{x} {y} of {size}");
        }
    }
}

#[test]
fn tiles_put_together_are_the_picture_they_were_cut_from() {
    let planes = [0, 1].map(|c: usize| (0..SIZE.pixels()).map(|i| (100 * c + i) as f32).collect::<Vec<f32>>());
    for side in [1, 4, 20] {
        let tiles = tiles_of(SIZE, side);
        let cut = |tile: &Rectangle, plane: &Vec<f32>| -> Vec<f32> {
            pixels(SIZE).filter(|(x, y)| tile.contains(*x, *y)).map(|(x, y)| plane[SIZE.index(x, y)]).collect()
        };
        let parts: Vec<Vec<Vec<f32>>> =
            tiles.iter().map(|tile| planes.iter().map(|plane| cut(tile, plane)).collect()).collect();
        assert_eq!(put_together(SIZE, &tiles, &parts, 2), planes);
    }
}

#[test]
fn a_grown_rectangle_holds_what_is_near() {
    for by in [0, 1, 3, 20] {
        let grown = PART.grown(by, SIZE);
        for (x, y) in pixels(SIZE) {
            let near = pixels(SIZE).any(|(p, q)| PART.contains(p, q) && p.abs_diff(x) <= by && q.abs_diff(y) <= by);
            assert_eq!(grown.contains(x, y), near, "{x} {y} by {by}");
        }
    }
}

#[test]
fn pixels_stay_inside_when_moved() {
    for dx in -11..=11_isize {
        for dy in -9..=9_isize {
            let inside = PART.where_inside([dx, dy], SIZE);
            let moved_inside = |x: usize, y: usize| {
                (0..SIZE.width as isize).contains(&(x as isize + dx))
                    && (0..SIZE.height as isize).contains(&(y as isize + dy))
            };
            let expected = pixels(SIZE).filter(|(x, y)| PART.contains(*x, *y) && moved_inside(*x, *y)).count();
            assert_eq!(inside.width() * inside.height(), expected, "[{dx}, {dy}]");
            for (x, y) in pixels(SIZE).filter(|(x, y)| inside.contains(*x, *y)) {
                assert!(PART.contains(x, y) && moved_inside(x, y), "{x} {y} moved by [{dx}, {dy}]");
            }
        }
    }
}
