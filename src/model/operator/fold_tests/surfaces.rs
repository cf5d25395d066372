use super::*;

/// A plate whose left edge is a surface with a flux of 0.75, between insulated faces.
fn flat_surface(kernel: KernelKind, dimension: usize, support_ratio: f64) -> Problem {
    let mut problem = walled(kernel, dimension, support_ratio, WallKind::Insulated);
    problem.walls.retain(|wall| wall.face.axis > 0);
    let foot = |x: DVec3| DVec3::new(0.0, x.y, x.z);
    let beyond = Region::new(|x| x.x < 0.0);
    let condition = Condition::flux(ScalarField::constant(0.75));
    problem.surfaces = vec![Surface::new("left", beyond, foot, None, condition)];
    problem
}

#[test]
fn a_flat_surface_takes_the_whole_flux() {
    each_kernel_and_dimension(|kernel, dimension, support_ratio| {
        let mut problem = flat_surface(kernel, dimension, support_ratio);
        for faces in ["insulated", "free"] {
            let state = vec![3.0; problem.particles.len()];
            let given = Assembled::new(&problem).given(&problem, &state);
            let off = given / (0.75 * area_of_x_min(&problem)) - 1.0;
            assert!(off.abs() < 1e-9, "{kernel:?} {dimension}-D {support_ratio} {faces}: {off:e}");
            problem.walls.clear();
        }
    });
}

#[test]
fn a_surface_inside_the_body_is_a_fault() {
    let mut problem = flat_surface(KernelKind::CubicSpline, 2, 2.0);
    let fault = |problem: &Problem| {
        crate::model::operator::rows::survey(problem, &cell_grid(problem)).fault
    };
    assert_eq!(fault(&problem), None);
    let foot = |x: DVec3| DVec3::new(1.0, x.y, x.z);
    let beyond = Region::new(|x| x.x < 1.0);
    let condition = Condition::flux(ScalarField::constant(0.75));
    problem.surfaces = vec![Surface::new("middle", beyond, foot, None, condition)];
    assert!(matches!(fault(&problem), Some(Fault::Inside { imposed: 2, .. })));
    let undefined = ScalarField::new("0/t", |_, t| 0.0 / t);
    problem.surfaces.clear();
    problem.walls[0].condition = Condition::value(undefined);
    assert!(matches!(fault(&problem), Some(Fault::NotFinite { imposed: 0, .. })));
}

/// A lattice of the points of a shape, around the origin of the box from -1 to 1.
fn cut_out(dimension: usize, count: usize, shape: &Region) -> Problem {
    let counts = std::array::from_fn(|axis| if axis < dimension { count } else { 1 });
    let spacing = 2.0 / count as f64;
    let mut problem = lattice(KernelKind::CubicSpline, dimension, counts, spacing, 2.0);
    let shift = (0..dimension).fold(DVec3::ZERO, |shift, axis| shift + DVec3::AXES[axis]);
    let position = problem.particles.position.iter().map(|&x| x - shift);
    problem.particles.position = position.filter(|&x| shape.contains(x)).collect();
    let left = problem.particles.position.len();
    problem.particles.volume.truncate(left);
    problem.particles.material.truncate(left);
    problem.initial.truncate(left);
    problem.domain.min = -shift;
    problem.domain.max = shift;
    problem
}

/// What enters of a unit flux through a circle or sphere of radius 0.8 (0.4 for `hole`) over what
/// should, into what lies within (outside of) it, up to radius `outer`.
fn entered(dimension: usize, count: usize, hole: bool, outer: f64) -> f64 {
    let radius = if hole { 0.4 } else { 0.8 };
    let ball = Region::new(move |x| x.length() <= radius);
    let body = ball.clone();
    let body = Region::new(move |x| body.contains(x) != hole && x.length() <= outer);
    let mut problem = cut_out(dimension, count, &body);
    let foot = move |x: DVec3| radius * x.normalize_or(DVec3::X);
    let condition = Condition::flux(ScalarField::constant(1.0));
    problem.surfaces = vec![Surface::new("round", ball, foot, None, condition)];
    let state = vec![3.0; problem.particles.len()];
    let area = match dimension {
        2 => 2.0 * std::f64::consts::PI * radius,
        _ => 4.0 * std::f64::consts::PI * radius * radius,
    };
    Assembled::new(&problem).given(&problem, &state) / area
}

#[test]
fn curved_surfaces_take_the_whole_flux_thin_bodies_too() {
    for (dimension, count) in [(2, 80), (3, 40)] {
        for (hole, outer) in [(false, 1.0), (true, 0.9), (true, 0.4 + 4.0 / count as f64)] {
            let found = entered(dimension, count, hole, outer);
            assert!((found - 1.0).abs() < 0.02, "{dimension}-D {hole} {outer}: {found}");
        }
    }
}

#[test]
fn the_edges_of_a_square_take_their_flux() {
    let square = Region::new(|x: DVec3| x.abs().max_element() <= 0.8);
    let mut problem = cut_out(2, 40, &square);
    let foot = |x: DVec3| {
        let axis = usize::from(x.y.abs() > x.x.abs());
        let mut foot = x.clamp(DVec3::splat(-0.8), DVec3::splat(0.8));
        if x.abs().max_element() <= 0.8 {
            foot[axis] = 0.8_f64.copysign(x[axis]);
        }
        foot
    };
    let condition = Condition::flux(ScalarField::constant(1.0));
    problem.surfaces = vec![Surface::new("square", square, foot, None, condition)];
    let state = vec![3.0; problem.particles.len()];
    let found = Assembled::new(&problem).given(&problem, &state) / 6.4;
    assert!((found - 1.0).abs() < 0.02, "{found}");
}
