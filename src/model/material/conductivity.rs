//! Conductivities that depend on temperature.

/// A conductivity that depends on temperature: straight between its points, constant beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct Conductivity {
    /// Temperatures (K), ascending, with the conductivity there, W/(m K), positive.
    points: Vec<[f64; 2]>,
    /// Temperatures between which it is known, K.
    limits: [f64; 2],
}

/// Everywhere.
const NO_LIMITS: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

impl Conductivity {
    /// One that does not depend on temperature.
    pub fn constant(conductivity: f64) -> Self {
        Self { points: vec![[0.0, conductivity]], limits: NO_LIMITS }
    }

    /// From temperatures and conductivities.
    ///
    /// # Panics
    /// If there is no point, or temperatures do not ascend.
    pub fn of_points(points: Vec<[f64; 2]>) -> Self {
        assert!(!points.is_empty(), "at least one point");
        assert!(points.windows(2).all(|two| two[0][0] < two[1][0]), "temperatures ascend");
        Self { points, limits: NO_LIMITS }
    }

    /// The same, known only between two temperatures, K.
    pub fn within_limits(self, limits: [f64; 2]) -> Self {
        Self { limits, ..self }
    }

    /// The temperatures between which it is known, K.
    pub fn limits(&self) -> [f64; 2] {
        self.limits
    }

    /// Whether it is the same everywhere.
    pub fn is_constant(&self) -> bool {
        self.points.iter().all(|point| point[1] == self.points[0][1])
    }

    /// The largest, W/(m K).
    pub fn largest(&self) -> f64 {
        self.points.iter().map(|point| point[1]).fold(0.0, f64::max)
    }

    /// At a temperature (K), W/(m K).
    pub fn at(&self, temperature: f64) -> f64 {
        let next = self.points.partition_point(|point| point[0] <= temperature);
        let (Some(below), Some(above)) =
            (next.checked_sub(1).map(|k| self.points[k]), self.points.get(next))
        else {
            return self.points[next.min(self.points.len() - 1)][1];
        };
        below[1] + (above[1] - below[1]) * (temperature - below[0]) / (above[0] - below[0])
    }

    /// The temperatures of its points strictly between two.
    pub(super) fn within(&self, from: f64, to: f64) -> impl Iterator<Item = f64> + '_ {
        let points = if self.is_constant() { &[] } else { &*self.points };
        points.iter().map(|point| point[0]).filter(move |&t| t > from && t < to)
    }
}

/// Pieces that an expression is cut into to begin with.
const PIECES: u32 = 32;

/// How often a piece is halved at most.
const HALVINGS: u32 = 12;

/// Points between which `function`, a conductivity over temperature (K), is straight within `tolerance` of
/// itself, and the temperatures between which it is positive and finite around `needed`, in `range`.
pub fn straightened(
    function: &dyn Fn(f64) -> f64,
    range: [f64; 2],
    needed: [f64; 2],
    tolerance: f64,
) -> (Vec<[f64; 2]>, [f64; 2]) {
    let limits = [end(function, needed[0], range[0]), end(function, needed[1], range[1])];
    let [from, to] = limits;
    let point = |temperature: f64| [temperature, function(temperature)];
    let mut points = vec![point(from)];
    for piece in 0..PIECES {
        let share = f64::from(piece + 1) / f64::from(PIECES);
        // The very end, whatever rounding makes of it.
        let next = if piece + 1 == PIECES { to } else { from + share * (to - from) };
        halve(function, point(next), tolerance, HALVINGS, &mut points);
    }
    (points, limits)
}

/// The last temperature from `needed` towards `far` up to which `function` is positive and finite.
fn end(function: &dyn Fn(f64) -> f64, needed: f64, far: f64) -> f64 {
    let is_good = |temperature: f64| {
        let value = function(temperature);
        value > 0.0 && value.is_finite()
    };
    let at = |share: f64| needed + share * (far - needed);
    let (mut good, mut bad) = (0.0, None);
    for step in 1..=1000 {
        let share = f64::from(step) / 1000.0;
        if !is_good(at(share)) {
            bad = Some(share);
            break;
        }
        good = share;
    }
    let Some(mut bad) = bad else {
        return far;
    };
    for _ in 0..40 {
        let middle = 0.5 * (good + bad);
        if is_good(at(middle)) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    at(good)
}

/// Adds the points from the last one to `to`.
fn halve(
    function: &dyn Fn(f64) -> f64,
    to: [f64; 2],
    tolerance: f64,
    halvings: u32,
    points: &mut Vec<[f64; 2]>,
) {
    let from = points[points.len() - 1];
    let off = |share: f64| {
        let exact = function(from[0] + share * (to[0] - from[0]));
        (from[1] + share * (to[1] - from[1]) - exact).abs() / exact
    };
    if halvings > 0 && [0.25, 0.5, 0.75].into_iter().any(|share| off(share) > tolerance) {
        let middle = 0.5 * (from[0] + to[0]);
        halve(function, [middle, function(middle)], tolerance, halvings - 1, points);
        halve(function, to, tolerance, halvings - 1, points);
    } else {
        points.push(to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_straight_between_its_points_and_constant_beyond() {
        let table = Conductivity::of_points(vec![[300.0, 10.0], [400.0, 30.0], [500.0, 20.0]]);
        let found = [200.0, 300.0, 350.0, 400.0, 475.0, 900.0].map(|t| table.at(t));
        assert_eq!(found, [10.0, 10.0, 20.0, 30.0, 22.5, 20.0]);
        assert!(!table.is_constant() && Conductivity::constant(3.0).is_constant());
    }

    #[test]
    fn an_expression_is_met_as_well_as_asked() {
        let function = |t: f64| 40.0 * (t / 300.0).powf(-1.2);
        let worst = |tolerance: f64| {
            let (points, limits) =
                straightened(&function, [200.0, 900.0], [300.0, 400.0], tolerance);
            assert_eq!(limits, [200.0, 900.0]);
            let table = Conductivity::of_points(points);
            let off = |k: u32| {
                let t = 200.0 + 0.35 * f64::from(k);
                (table.at(t) / function(t) - 1.0).abs()
            };
            (0..=2000).map(off).fold(0.0, f64::max)
        };
        assert!(worst(1e-6) < 1.2e-6, "{:e}", worst(1e-6));
        assert!(worst(1e-2) > 1e-4, "and no better: {:e}", worst(1e-2));
    }

    #[test]
    fn an_expression_ends_where_it_is_not_positive() {
        let (points, limits) = straightened(&|t| 500.0 - t, [100.0, 900.0], [300.0, 400.0], 1e-6);
        assert!((limits[1] - 500.0).abs() < 1e-6 && limits[1] <= 500.0 && limits[0] == 100.0);
        assert!(points.iter().all(|point| point[1] > 0.0));
    }
}
