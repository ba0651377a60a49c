//! Height fields whose height can be asked for exactly where their triangles are.

use glam::{DVec2, DVec3};

use super::builder::Shape;

/// Heights on a grid, joined by triangles: every cell is cut along its diagonal from (low x, low z) to (high x, high z).
#[derive(Debug, Clone)]
pub(super) struct HeightField {
    origin: DVec2,
    cell: DVec2,
    cells: [usize; 2],
    heights: Vec<f64>,
}

impl HeightField {
    /// The field over a rectangle of the xz plane.
    pub(super) fn new(min: DVec2, max: DVec2, cells: [usize; 2], height: impl Fn(f64, f64) -> f64) -> Self {
        let cell = (max - min) / DVec2::new(cells[0] as f64, cells[1] as f64);
        let at = |i: usize, j: usize| height(min.x + cell.x * i as f64, min.y + cell.y * j as f64);
        let heights = (0..=cells[1]).flat_map(|j| (0..=cells[0]).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect();
        Self { origin: min, cell, cells, heights }
    }
    /// The height of the triangle above or below a point; outside the rectangle the nearest border cell's continued.
    pub(super) fn height_at(&self, x: f64, z: f64) -> f64 {
        let p = (DVec2::new(x, z) - self.origin) / self.cell;
        let i = p.x.floor().clamp(0.0, self.cells[0] as f64 - 1.0);
        let j = p.y.floor().clamp(0.0, self.cells[1] as f64 - 1.0);
        let (u, v) = (p.x - i, p.y - j);
        let (i, j) = (i as usize, j as usize);
        let (low, high) = (self.height(i, j), self.height(i + 1, j + 1));
        if u >= v {
            let corner = self.height(i + 1, j);
            low + u * (corner - low) + v * (high - corner)
        } else {
            let corner = self.height(i, j + 1);
            low + v * (corner - low) + u * (high - corner)
        }
    }
    /// The field as the top of a solid with upright sides down to `bottom` (below every height).
    pub(super) fn solid(&self, bottom: f64) -> Shape {
        let [nx, nz] = self.cells;
        let mut shape = Shape::default();
        for j in 0..=nz {
            for i in 0..=nx {
                shape.push_vertex(self.point(i, j, self.height(i, j)));
            }
        }
        let index = |i: usize, j: usize| j * (nx + 1) + i;
        for j in 0..nz {
            for i in 0..nx {
                let (a, b, c, d) = (index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
                shape.push_face([a, c, b]);
                shape.push_face([a, d, c]);
            }
        }
        // Once around the border, counter-clockwise as seen from above (x to the right, z down).
        let border: Vec<(usize, usize)> = (0..nx)
            .map(|i| (i, nz))
            .chain((1..=nz).rev().map(|j| (nx, j)))
            .chain((1..=nx).rev().map(|i| (i, 0)))
            .chain((0..nz).map(|j| (0, j)))
            .collect();
        let floor: Vec<usize> = border.iter().map(|&(i, j)| shape.push_vertex(self.point(i, j, bottom))).collect();
        let middle = (self.point(0, 0, bottom) + self.point(nx, nz, bottom)) * 0.5;
        let center = shape.push_vertex(middle);
        for k in 0..border.len() {
            let next = (k + 1) % border.len();
            let (a, b) = (index(border[k].0, border[k].1), index(border[next].0, border[next].1));
            shape.push_face([floor[k], floor[next], b]);
            shape.push_face([floor[k], b, a]);
            shape.push_face([center, floor[next], floor[k]]);
        }
        shape
    }
    fn height(&self, i: usize, j: usize) -> f64 {
        self.heights[j * (self.cells[0] + 1) + i]
    }
    fn point(&self, i: usize, j: usize, height: f64) -> DVec3 {
        let p = self.origin + self.cell * DVec2::new(i as f64, j as f64);
        DVec3::new(p.x, height, p.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn height_at_is_the_field_at_its_points_and_linear_along_the_diagonals() {
        let field = HeightField::new(DVec2::new(-3.0, 2.0), DVec2::new(5.0, 6.0), [4, 2], |x, z| x * z + x * x);
        let f = |x: f64, z: f64| x * z + x * x;
        for (x, z) in [(-3.0, 2.0), (-1.0, 4.0), (5.0, 6.0), (3.0, 2.0)] {
            assert_eq!(field.height_at(x, z), f(x, z));
        }
        // The middle of a cell lies on its diagonal, the middles of edges on the edges.
        assert_eq!(field.height_at(0.0, 3.0), 0.5 * (f(-1.0, 2.0) + f(1.0, 4.0)));
        assert_eq!(field.height_at(0.0, 4.0), 0.5 * (f(-1.0, 4.0) + f(1.0, 4.0)));
        assert_eq!(field.height_at(1.0, 5.0), 0.5 * (f(1.0, 4.0) + f(1.0, 6.0)));
    }
}
