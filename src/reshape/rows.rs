//! Weighted scalar residuals of the shape, with their gradients.

use std::ops::Range;

use crate::fem::MaterialPoint;
use crate::math::Vec3;

/// A set of weighted residuals.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// The rows.
    pub rows: Vec<Row>,
    /// The gradients of all rows: vertices and directions, row after row.
    gradients: Vec<(u32, Vec3)>,
}

/// One scalar residual.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its place among the gradients.
    gradient: Range<usize>,
    /// Its value at the present shape.
    pub residual: f64,
    /// c = 1 / sigma^2.
    pub weight: f64,
    /// Whether it only holds steps back, and says nothing of the person.
    holds: bool,
}

impl Rows {
    /// Adds rows of one point: direction . (point - target) for each direction of unit length, with
    /// its value at the present shape and its weight.
    pub fn add(&mut self, point: &MaterialPoint, rows: impl IntoIterator<Item = (Vec3, f64, f64)>) {
        for (direction, residual, weight) in rows {
            self.push(point.0.iter().map(|&(v, w)| (v, direction * w)), residual, weight);
        }
    }

    /// The same of rows that only hold steps back.
    pub fn hold(
        &mut self,
        point: &MaterialPoint,
        rows: impl IntoIterator<Item = (Vec3, f64, f64)>,
    ) {
        let first = self.rows.len();
        self.add(point, rows);
        for row in &mut self.rows[first..] {
            row.holds = true;
        }
    }

    /// Those that say something of the person.
    #[must_use]
    pub fn evidence(&self) -> Self {
        let rows = self.rows.iter().filter(|row| !row.holds && row.weight > 0.0);
        Self { rows: rows.cloned().collect(), gradients: self.gradients.clone() }
    }

    /// Adds a row by its gradient.
    pub fn push(
        &mut self,
        gradient: impl IntoIterator<Item = (u32, Vec3)>,
        residual: f64,
        weight: f64,
    ) {
        let first = self.gradients.len();
        self.gradients.extend(gradient);
        let gradient = first..self.gradients.len();
        self.rows.push(Row { gradient, residual, weight, holds: false });
    }

    /// The vertices that move a row's residual, and how.
    pub fn gradient(&self, row: &Row) -> &[(u32, Vec3)] {
        &self.gradients[row.gradient.clone()]
    }

    /// 1/2 sum c residual^2.
    pub fn energy(&self) -> f64 {
        self.energy_from(0)
    }

    /// The same of the rows from the `first` on.
    pub(super) fn energy_from(&self, first: usize) -> f64 {
        0.5 * self.rows[first..].iter().map(|r| r.weight * r.residual * r.residual).sum::<f64>()
    }

    /// sqrt(c) residual, per row.
    pub(super) fn residuals(&self) -> Vec<f64> {
        self.rows.iter().map(|r| r.weight.sqrt() * r.residual).collect()
    }

    /// sqrt(c) gradient . field, per row.
    pub fn measure(&self, field: &[Vec3]) -> Vec<f64> {
        let change = |row: &Row| -> f64 {
            self.gradient(row).iter().map(|&(v, g)| g.dot(&field[v as usize])).sum()
        };
        self.rows.iter().map(|row| row.weight.sqrt() * change(row)).collect()
    }

    /// sum over rows of a sqrt(c) gradient, per vertex.
    pub(super) fn spread(&self, a: &[f64], vertices: usize) -> Vec<Vec3> {
        let mut field = vec![Vec3::zeros(); vertices];
        for (row, a) in self.rows.iter().zip(a) {
            for &(v, g) in self.gradient(row) {
                field[v as usize] += g * (row.weight.sqrt() * a);
            }
        }
        field
    }
}
