//! Standing waves between two faces, and the search for their wave numbers.

use std::f64::consts::PI;

use super::side::Condition;
use super::zero_flux_box::NEGLIGIBLE_EXPONENT;

/// D t / L^2 up to which the faces of a body of width L do not feel each other: what one does is
/// below 2e-23 at the other.
pub(super) const SHORT: f64 = 0.005;

/// How many waves are kept. The first one left out is below exp(-44) at `SHORT`.
pub(super) const COUNT: usize = 30;

/// A function's value and derivative at a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub(super) value: f64,
    pub(super) slope: f64,
}

/// amplitude cos(root x - phase) on 0 <= x <= 1, one term of an eigenfunction series.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mode {
    pub(super) root: f64,
    pub(super) phase: f64,
    pub(super) amplitude: f64,
}

impl Mode {
    /// The wave X of wave number b with `index` zeros between the faces (and one at a held face),
    /// and its share of a function f, given by its ends.
    ///
    /// X = cos(b x - a0) meets the left condition, with nothing on its right-hand side, and the
    /// right one where b - a0(b) - a1(b) = index pi, with a0 and a1 the faces' angles. The only
    /// root above `low` is below (index + 1) pi. If f'' is 0, or X orthogonal to it, Green's
    /// identity has int f X = -[f X' - f' X] / b^2 and int X^2 = (1 - [X X'] / b^2) / 2. They hold
    /// for any b, so that the last digit of the root does not matter.
    pub(super) fn new(index: usize, low: f64, faces: [Condition; 2], ends: [End; 2]) -> Self {
        let turns = index as f64 * PI;
        let angles = |b: f64| faces[0].angle(b) + faces[1].angle(b);
        let root = bisect(low, turns + PI, |b| b - angles(b) - turns);
        let phase = faces[0].angle(root);
        let waves =
            [0.0, root].map(|x| End { value: (x - phase).cos(), slope: -root * (x - phase).sin() });
        let jump = |part: &dyn Fn(usize) -> f64| (part(1) - part(0)) / (root * root);
        let overlap = -jump(&|i| ends[i].value * waves[i].slope - ends[i].slope * waves[i].value);
        let norm = 0.5 * (1.0 - jump(&|i| waves[i].value * waves[i].slope));
        Self { root, phase, amplitude: overlap / norm }
    }

    /// Its value at `place` and `time`, in units of L and L^2 / D.
    pub(super) fn at(&self, place: f64, time: f64) -> f64 {
        self.amplitude * (self.root * place - self.phase).cos() * decay(self.root, time)
    }
}

/// exp(-root^2 time), and 0 where that does not count.
pub(super) fn decay(root: f64, time: f64) -> f64 {
    let exponent = root * root * time;
    if exponent < NEGLIGIBLE_EXPONENT { (-exponent).exp() } else { 0.0 }
}

/// The root of `f` between `low` and `high`, to the last digit; `f` rises through it.
pub(super) fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if f(middle) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
}
