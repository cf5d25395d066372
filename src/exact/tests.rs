//! Each solution against its equation, its boundary conditions, its integral and known values.

mod annulus;
mod continuous_point_source;
mod half_space;
mod heated_slab;
mod layers;
mod neumann;
mod oscillating_slab;
mod slab;
mod sphere;

use super::zero_flux_box::{cosines, images};
use super::*;

const YEAR: f64 = 31_536_000.0;

fn walls(dimension: usize) -> ZeroFluxBox {
    let max = DVec3::new(1.0, 1.5, 0.8);
    ZeroFluxBox { dimension, min: DVec3::ZERO, max, diffusivity: 0.3 }
}

/// A point whose coordinates past `dimension` are 0, as everywhere in a scene.
fn point(dimension: usize, coordinates: [f64; 3]) -> DVec3 {
    let mut x = DVec3::ZERO;
    for axis in 0..dimension {
        x[axis] = coordinates[axis];
    }
    x
}

fn transient(dimension: usize) -> Vec<Solution> {
    let at = point(dimension, [0.3, 0.6, 0.5]);
    vec![
        Solution::PointSource(PointSource {
            dimension,
            amount: 2.0,
            at,
            diffusivity: 0.3,
            porosity: 0.7,
        }),
        Solution::PointSourceInBox(PointSourceInBox {
            walls: walls(dimension),
            amount: 2.0,
            at,
            porosity: 0.7,
        }),
        Solution::MassesInBox(MassesInBox {
            walls: walls(dimension),
            amount: 2.0,
            at,
            separation: 0.2,
        }),
    ]
}

/// |dC/dt - D laplacian C| over |dC/dt| + |D laplacian C|, the greatest of each at the points, by
/// fourth-order differences.
fn residual(
    solution: &Solution,
    dimension: usize,
    diffusivity: f64,
    points: &[DVec3],
    (t, time_step): (f64, f64),
) -> f64 {
    let step = 2e-3;
    let first = |f: &dyn Fn(f64) -> f64, h: f64| {
        (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
    };
    let second = |f: &dyn Fn(f64) -> f64, h: f64| {
        (16.0 * (f(h) + f(-h)) - (f(2.0 * h) + f(-2.0 * h)) - 30.0 * f(0.0)) / (12.0 * h * h)
    };
    let (mut difference, mut size) = (0.0f64, 0.0f64);
    for &x in points {
        let rate = first(&|s| solution.at(x, t + s), time_step);
        let laplacian: f64 = (0..dimension)
            .map(|axis| second(&|s| solution.at(x + s * DVec3::AXES[axis], t), step))
            .sum();
        let spread = diffusivity * laplacian;
        difference = difference.max((rate - spread).abs());
        size = size.max(rate.abs() + spread.abs());
    }
    difference / size
}

/// How far `solution` is from what `side` asks for at `face` and `t`; `out` is a unit normal.
fn broken(
    solution: &Solution,
    side: Side,
    diffusivity: f64,
    (face, out): (DVec3, DVec3),
    t: f64,
) -> f64 {
    let step = 2e-4;
    let at = |n: f64| solution.at(face - n * step * out, t);
    let inward = -25.0 * at(0.0) + 48.0 * at(1.0) - 36.0 * at(2.0) + 16.0 * at(3.0) - 3.0 * at(4.0);
    let flux = -diffusivity * inward / (12.0 * step);
    match side {
        Side::Value(value) => at(0.0) - value,
        Side::Flux(given) => flux - given,
        Side::Convection { coefficient, ambient } => flux - coefficient * (ambient - at(0.0)),
    }
    .abs()
}

/// What an error of a condition is measured by: the coefficient multiplies that of the value.
fn side_scale(side: Side) -> f64 {
    if let Side::Convection { coefficient, .. } = side { coefficient.max(1.0) } else { 1.0 }
}

/// The integral of `f` from `from` to `to` by Simpson's rule.
fn integral(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let n = 2000;
    let step = (to - from) / f64::from(n);
    let weight = |i: i32| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
    (0..=n).map(|i| weight(i) * f(from + f64::from(i) * step)).sum::<f64>() * step / 3.0
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance, "{found}, expected {expected}");
}

#[test]
fn solutions_satisfy_the_equation() {
    for dimension in 1..=3 {
        let x = point(dimension, [0.42, 0.71, 0.37]);
        for solution in transient(dimension) {
            for t in [0.02, 0.11, 0.9] {
                let found = residual(&solution, dimension, 0.3, &[x], (t, 1e-2 * t));
                assert!(found < 1e-5, "{} {dimension}-D t = {t}: {found}", solution.name());
                // Negative control: another diffusivity does not satisfy it.
                let wrong = residual(&solution, dimension, 0.33, &[x], (t, 1e-2 * t));
                assert!(wrong > 1e-2, "{}", solution.name());
            }
        }
    }
}

#[test]
fn masses_are_kept_and_nothing_crosses_the_walls() {
    let n = 40;
    for dimension in 1..=3 {
        for (index, mass) in [(1, 2.0 / 0.7), (2, 2.0)] {
            let solution = &transient(dimension)[index];
            for t in [0.05, 0.4, 5.0] {
                let walls = walls(dimension);
                let count = |axis: usize| if axis < dimension { n } else { 1 };
                let mut sum = 0.0;
                for i in 0..count(0) * count(1) * count(2) {
                    let index = [i % n, i / n % n, i / (n * n)];
                    let mut x = DVec3::ZERO;
                    for axis in 0..dimension {
                        x[axis] = (index[axis] as f64 + 0.5) / n as f64 * walls.max[axis];
                    }
                    sum += solution.at(x, t);
                }
                // The midpoint rule is spectrally accurate for zero flux at the ends.
                let cell: f64 = (0..dimension).map(|axis| walls.max[axis] / n as f64).product();
                assert!((sum * cell / mass - 1.0).abs() < 1e-12, "{dimension}-D, t = {t}");
                for axis in 0..dimension {
                    let mut near = DVec3::splat(0.2);
                    near[axis] = walls.max[axis] - 1e-4;
                    let mut beyond = near;
                    beyond[axis] = walls.max[axis] + 1e-4;
                    let (near, beyond) = (solution.at(near, t), solution.at(beyond, t));
                    assert!((near / beyond - 1.0).abs() < 1e-12, "{near} {beyond}");
                }
            }
        }
    }
}

#[test]
fn the_two_forms_agree() {
    for time in [0.05, 0.159, 0.3] {
        for (x, mass) in [(0.0, 1.0), (0.3, 0.3), (0.25, 0.9), (1.0, 1.0)] {
            let ratio = images(x, mass, time) / cosines(x, mass, time);
            assert!((ratio - 1.0).abs() < 1e-13, "{time} {x} {mass}: {ratio}");
        }
    }
}

#[test]
fn short_times_are_accurate() {
    // The nearest image alone, e^-1000 times the peak: summed, not drowned in round-off.
    let far = images(0.9, 0.1, 0.16 / 100.0 * 0.25);
    let alone = (-0.64f64 / (4.0 * 4e-4)).exp() / (4.0 * std::f64::consts::PI * 4e-4).sqrt();
    assert!((far / alone - 1.0).abs() < 1e-10, "{far} {alone}");
}

#[test]
fn known_values() {
    let at = DVec3::splat(25.0);
    let x = DVec3::splat(25.25);
    let diffusivity = 15.0 / YEAR;
    let free = PointSource { dimension: 3, amount: 1000.0, at, diffusivity, porosity: 1.0 };
    close(free.at(x, 2.0 * YEAR), 0.13640326, 5e-9);
    let walls = ZeroFluxBox { dimension: 3, min: DVec3::ZERO, max: 2.0 * at, diffusivity };
    let masses = MassesInBox { walls, amount: 1000.0, at, separation: 0.5 };
    close(masses.at(x, 2.0 * YEAR), 0.13619051, 5e-9);
}

#[test]
fn ends_of_time_and_space() {
    let x = DVec3::new(0.9, 0.9, 0.7);
    for solution in &transient(3)[..3] {
        assert_eq!(solution.at(x, 0.0), 0.0, "{}", solution.name());
    }
    let source = &transient(3)[0];
    assert_eq!(source.at(DVec3::new(0.3, 0.6, 0.5), 0.0), f64::INFINITY);
}

#[test]
fn an_amount_of_zero_is_zero_everywhere() {
    let at = DVec3::new(0.3, 0.6, 0.5);
    let free = PointSource { dimension: 3, amount: 0.0, at, diffusivity: 0.3, porosity: 0.7 };
    let boxed = PointSourceInBox { walls: walls(3), amount: 0.0, at, porosity: 0.7 };
    let masses = MassesInBox { walls: walls(3), amount: 0.0, at, separation: 0.2 };
    for t in [0.0, 0.1] {
        assert_eq!((free.at(at, t), boxed.at(at, t)), (0.0, 0.0));
        assert_eq!(masses.at(at + DVec3::splat(0.5 * 0.2), t), 0.0);
    }
}

#[test]
fn evaluate_is_at_of_every_position() {
    let field = ScalarField::new("x*t", |x, t| x.x * t);
    let affine = Solution::Affine { offset: 1.0, gradient: DVec3::new(2.0, 0.0, 3.0) };
    let positions = [DVec3::ZERO, DVec3::ONE, DVec3::new(1.0, 2.0, 3.0)];
    assert_eq!(affine.evaluate(&positions, 0.0), [1.0, 6.0, 12.0]);
    assert_eq!(Solution::Expression(field).evaluate(&positions, 2.0), [0.0, 2.0, 2.0]);
    assert_eq!(Solution::Uniform { value: 4.0 }.evaluate(&positions, 2.0), [4.0; 3]);
}
