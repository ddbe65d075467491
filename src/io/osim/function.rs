//! Functions of one coordinate, with OpenSim's own values.

use roxmltree::Node;

use super::xml::{child_number, child_numbers, name};

/// A function that is a multiple of the one inside it.
const MULTIPLIER: &str = "MultiplierFunction";
/// Names of the functions that are read.
const KNOWN: [&str; 6] = [
    "Constant",
    "LinearFunction",
    "SimmSpline",
    "PiecewiseLinearFunction",
    "PolynomialFunction",
    MULTIPLIER,
];

/// A function of one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub enum Function {
    /// Coefficients, that of the highest power first; `Constant` and `LinearFunction` too.
    Polynomial(Vec<f64>),
    /// A cubic spline with straight ends (`SimmSpline`), or straight pieces throughout.
    Pieces(Pieces),
}

/// A function given at knots: `y + b h + c h^2 + d h^3` at a distance `h` behind a knot, straight before
/// the first and behind the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Pieces {
    x: Vec<f64>,
    /// `[y, b, c, d]` for each knot.
    cubics: Vec<[f64; 4]>,
}

impl Function {
    /// A number that stays.
    pub fn constant(value: f64) -> Self {
        Self::Polynomial(vec![value])
    }

    /// The coordinate itself.
    pub fn identity() -> Self {
        Self::Polynomial(vec![1.0, 0.0])
    }

    /// The function among the children of `owner`; `None` if there is none.
    pub fn of(owner: &Node) -> Result<Option<Self>, String> {
        let Some((node, factor)) = innermost(owner) else { return Ok(None) };
        Ok(Some(Self::parse(&node)?.times(factor)))
    }

    fn parse(node: &Node) -> Result<Self, String> {
        let kind = node.tag_name().name();
        let bad = || format!("its <{kind}> is not usable");
        match kind {
            "Constant" => Ok(Self::constant(child_number(node, "value").unwrap_or(0.0))),
            "LinearFunction" | "PolynomialFunction" => {
                let coefficients = child_numbers(node, "coefficients").filter(|c| !c.is_empty());
                coefficients.map(Self::Polynomial).ok_or_else(bad)
            }
            "SimmSpline" | "PiecewiseLinearFunction" => {
                let knots = child_numbers(node, "x").zip(child_numbers(node, "y"));
                let knots = knots.filter(|(x, y)| !x.is_empty() && x.len() == y.len());
                let (x, y) = knots.filter(|(x, _)| x.is_sorted_by(|a, b| a < b)).ok_or_else(bad)?;
                let spline = kind == "SimmSpline";
                Ok(Self::Pieces(if spline { spline_through(x, &y) } else { lines_through(x, &y) }))
            }
            MULTIPLIER => Err(bad()),
            _ => Err(format!("its <{kind}> is not known; known are {}", KNOWN.join(", "))),
        }
    }

    /// The function's value.
    pub fn value(&self, at: f64) -> f64 {
        match self {
            Self::Polynomial(coefficients) => coefficients.iter().fold(0.0, |sum, c| sum * at + c),
            Self::Pieces(pieces) => pieces.value(at),
        }
    }

    /// Whether it has one value everywhere.
    pub fn is_constant(&self) -> bool {
        let zero = |coefficient: &f64| *coefficient == 0.0;
        match self {
            Self::Polynomial(coefficients) => coefficients.iter().rev().skip(1).all(zero),
            Self::Pieces(pieces) => {
                pieces.cubics.iter().all(|[_, rest @ ..]| rest.iter().all(zero))
            }
        }
    }

    /// The function times a number.
    #[must_use]
    pub fn times(mut self, factor: f64) -> Self {
        match &mut self {
            Self::Polynomial(coefficients) => coefficients.iter_mut().for_each(|c| *c *= factor),
            Self::Pieces(pieces) => {
                pieces.cubics.iter_mut().flatten().for_each(|c| *c *= factor);
            }
        }
        self
    }

    /// 1 or -1 if it is the coordinate itself or its opposite, perhaps with an offset.
    pub fn own_slope(&self) -> Option<f64> {
        match self {
            Self::Polynomial(c) if c.len() == 2 && (c[0].abs() - 1.0).abs() < 1e-12 => Some(c[0]),
            _ => None,
        }
    }
}

/// The function among the children of `owner` that is no multiple of another, and the product of the factors
/// around it. Functions may stand in a `<function>`.
pub(super) fn innermost<'a, 'i>(owner: &Node<'a, 'i>) -> Option<(Node<'a, 'i>, f64)> {
    let inside = |owner: &Node<'a, 'i>| {
        let known = |n: &Node| KNOWN.contains(&n.tag_name().name()) || name(n) == "function";
        let framed =
            || owner.children().find(|n| n.has_tag_name("function"))?.first_element_child();
        owner.children().find(known).or_else(framed)
    };
    let (mut node, mut factor) = (inside(owner)?, 1.0);
    while node.has_tag_name(MULTIPLIER)
        && let Some(inner) = inside(&node)
    {
        factor *= child_number(&node, "scale").unwrap_or(1.0);
        node = inner;
    }
    Some((node, factor))
}

impl Pieces {
    fn value(&self, at: f64) -> f64 {
        let last = self.x.len() - 1;
        let k = self.x.partition_point(|x| *x <= at).saturating_sub(1);
        let (h, [y, b, c, d]) = (at - self.x[k], self.cubics[k]);
        let straight = at < self.x[0] || k == last;
        if straight { y + b * h } else { y + h * (b + h * (c + h * d)) }
    }
}

fn lines_through(x: Vec<f64>, y: &[f64]) -> Pieces {
    let slope = |k: usize| (y[k + 1] - y[k]) / (x[k + 1] - x[k]);
    let cubics = (0..x.len()).map(|k| {
        let b = if x.len() < 2 { 0.0 } else { slope(k.min(x.len() - 2)) };
        [y[k], b, 0.0, 0.0]
    });
    Pieces { cubics: cubics.collect(), x }
}

/// OpenSim's `SimmSpline`: the cubic spline of Forsythe, Malcolm and Moler (1977), whose third derivative at
/// an end is that of the cubic through the four points there.
fn spline_through(x: Vec<f64>, y: &[f64]) -> Pieces {
    let n = x.len();
    if n < 3 {
        return lines_through(x, y);
    }
    let step: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
    let slope: Vec<f64> = y.windows(2).zip(&step).map(|(w, h)| (w[1] - w[0]) / h).collect();
    // One unknown per knot: a sixth of the second derivative. The matrix has the steps beside its diagonal.
    let (mut diagonal, mut sixth) = (vec![0.0; n], vec![0.0; n]);
    for k in 1..n - 1 {
        diagonal[k] = 2.0 * (step[k - 1] + step[k]);
        sixth[k] = slope[k] - slope[k - 1];
    }
    for (end, first) in [(0, 0), (n - 1, n.saturating_sub(4))] {
        let h = step[end.min(n - 2)];
        diagonal[end] = -h;
        if n > 3 {
            let second = |k: usize| (slope[k + 1] - slope[k]) / (x[k + 2] - x[k]);
            let third = (second(first + 1) - second(first)) / (x[first + 3] - x[first]);
            sixth[end] = third * h * h * if end == 0 { 1.0 } else { -1.0 };
        }
    }
    for k in 1..n {
        let factor = step[k - 1] / diagonal[k - 1];
        diagonal[k] -= factor * step[k - 1];
        sixth[k] -= factor * sixth[k - 1];
    }
    sixth[n - 1] /= diagonal[n - 1];
    for k in (0..n - 1).rev() {
        sixth[k] = (sixth[k] - step[k] * sixth[k + 1]) / diagonal[k];
    }
    let mut cubics: Vec<[f64; 4]> = (0..n - 1)
        .map(|k| {
            let b = slope[k] - step[k] * (sixth[k + 1] + 2.0 * sixth[k]);
            [y[k], b, 3.0 * sixth[k], (sixth[k + 1] - sixth[k]) / step[k]]
        })
        .collect();
    let end = slope[n - 2] + step[n - 2] * (sixth[n - 2] + 2.0 * sixth[n - 1]);
    cubics.push([y[n - 1], end, 0.0, 0.0]);
    Pieces { x, cubics }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Option<Function>, String> {
        let xml = roxmltree::Document::parse(text).unwrap();
        Function::of(&xml.root_element())
    }

    /// Values that OpenSim 4.6 gives for the same knots.
    #[test]
    fn a_spline_has_the_values_of_opensim() {
        let at = [-0.7, 0.05, 0.5, 1.3, 1.95, 2.6];
        let cases: [(&[f64], &[f64], [f64; 6]); 4] = [
            (
                &[0.0, 0.2, 0.7, 1.1, 2.0],
                &[0.0, 0.3, -0.1, 0.4, 0.9],
                [
                    -2.100_727_807_224_622,
                    0.129_392_344_651_102,
                    0.054_887_681_320_803,
                    0.762_483_295_583_083,
                    0.991_687_499_563_031,
                    -0.326_757_912_999_951,
                ],
            ),
            (
                &[0.0, 0.2, 2.0],
                &[0.0, 0.3, 0.9],
                [
                    -1.131_666_666_666_666,
                    0.079_375,
                    0.662_5,
                    1.115_833_333_333_333,
                    0.934_375,
                    0.47,
                ],
            ),
            (&[0.0, 2.0], &[0.0, 0.9], [-0.315, 0.022_5, 0.225, 0.585, 0.877_5, 1.17]),
            (
                &[0.0, 0.2, 0.7, 2.0],
                &[0.0, 0.3, -0.1, 0.9],
                [
                    -1.713_717_948_717_949,
                    0.109_776_785_714_286,
                    0.194_780_219_780_220,
                    -0.965,
                    0.579_687_5,
                    4.960_109_890_109_892,
                ],
            ),
        ];
        for (x, y, values) in cases {
            let spline = spline_through(x.to_vec(), y);
            for (at, value) in at.iter().zip(values) {
                assert!((spline.value(*at) - value).abs() < 1e-12, "{} knots at {at}", x.len());
            }
        }
    }

    #[test]
    fn functions_are_read_with_and_without_a_frame_around_them() {
        let line = "<LinearFunction><coefficients>2 1</coefficients></LinearFunction>";
        for text in [
            format!("<T>{line}</T>"),
            format!("<T><function>{line}</function></T>"),
            "<T><PiecewiseLinearFunction><x>0 1</x><y>1 3</y></PiecewiseLinearFunction></T>".into(),
        ] {
            assert!((parsed(&text).unwrap().unwrap().value(3.0) - 7.0).abs() < 1e-12);
        }
        let scaled = format!(
            "<T><MultiplierFunction><function>{line}</function><scale>3</scale></MultiplierFunction></T>"
        );
        assert!((parsed(&scaled).unwrap().unwrap().value(3.0) - 21.0).abs() < 1e-12);
        assert!(parsed("<T><axis>1 0 0</axis></T>").unwrap().is_none());
        let constant = parsed("<T><Constant><value>4</value></Constant></T>").unwrap().unwrap();
        assert_eq!((constant.value(9.0), constant.own_slope()), (4.0, None));
        assert_eq!(Function::identity().times(-1.0).own_slope(), Some(-1.0));
    }

    #[test]
    fn many_knots_and_many_factors_are_no_trouble() {
        let x: Vec<f64> = (0..200_000).map(f64::from).collect();
        let spline = spline_through(x.clone(), &x);
        assert!((spline.value(1234.5) - 1234.5).abs() < 1e-9);
        let depth = 200;
        let open = "<MultiplierFunction><scale>-1</scale><function>".repeat(depth);
        let close = "</function></MultiplierFunction>".repeat(depth);
        let text = format!("<T>{open}<Constant><value>2</value></Constant>{close}</T>");
        assert!((parsed(&text).unwrap().unwrap().value(0.0) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        let odd = "<T><GCVSpline name=\"function\"/></T>";
        assert!(parsed(odd).unwrap_err().contains("GCVSpline"));
        let uneven = "<T><SimmSpline><x>0 1</x><y>1</y></SimmSpline></T>";
        assert!(parsed(uneven).unwrap_err().contains("SimmSpline"));
        let backwards = "<T><SimmSpline><x>1 0</x><y>1 2</y></SimmSpline></T>";
        assert!(parsed(backwards).is_err());
    }
}
