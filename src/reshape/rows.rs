//! Weighted scalar residuals of points of the body.

use crate::fem::MaterialPoint;
use crate::math::Vec3;

/// A set of weighted residuals sqrt(weight) direction . (point - target).
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// Points of the body that rows refer to.
    pub points: Vec<MaterialPoint>,
    /// The rows.
    pub rows: Vec<Row>,
}

/// One scalar residual.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Index into the points.
    pub point: usize,
    /// Direction in which the residual is measured (unit length).
    pub direction: Vec3,
    /// direction . (point - target) at the present shape.
    pub residual: f64,
    /// c = 1 / sigma^2.
    pub weight: f64,
}

impl Rows {
    /// Adds the rows of one point.
    pub fn add(&mut self, point: MaterialPoint, rows: impl IntoIterator<Item = (Vec3, f64, f64)>) {
        let index = self.points.len();
        self.points.push(point);
        self.rows.extend(rows.into_iter().map(|(direction, residual, weight)| Row {
            point: index,
            direction,
            residual,
            weight,
        }));
    }

    /// 1/2 sum c residual^2.
    pub fn energy(&self) -> f64 {
        0.5 * self.rows.iter().map(|r| r.weight * r.residual * r.residual).sum::<f64>()
    }

    /// sqrt(c) residual, per row.
    pub(super) fn residuals(&self) -> Vec<f64> {
        self.rows.iter().map(|r| r.weight.sqrt() * r.residual).collect()
    }

    /// sqrt(c) direction . field(point), per row.
    pub(super) fn measure(&self, field: &[Vec3]) -> Vec<f64> {
        self.rows
            .iter()
            .map(|r| r.weight.sqrt() * r.direction.dot(&self.points[r.point].position(field)))
            .collect()
    }

    /// sum over rows of a sqrt(c) direction, spread to the vertices.
    pub(super) fn spread(&self, a: &[f64], vertices: usize) -> Vec<Vec3> {
        let mut field = vec![Vec3::zeros(); vertices];
        for (row, a) in self.rows.iter().zip(a) {
            let force = row.direction * (row.weight.sqrt() * a);
            for &(v, w) in &self.points[row.point].0 {
                field[v as usize] += force * w;
            }
        }
        field
    }
}
