//! What properties that depend on temperature ask of the rest of a case.

use super::error::CaseError;
use crate::model::lattice::sites_with_particles;
use crate::model::{Domain, Problem, ScalarField, Wall, WallKind};

/// The least and the greatest of the initial values and of what walls hold at t = 0, K.
pub(super) fn range_of_values(initial: &[f64], walls: &[Wall], domain: &Domain) -> [f64; 2] {
    let holds = |wall: &&Wall| wall.condition.kind == WallKind::Value;
    let corners = [domain.min, domain.max];
    let of_walls = walls
        .iter()
        .filter(holds)
        .flat_map(|wall| corners.map(|corner| wall.condition.imposed.at(corner, 0.0)));
    let join = |[least, most]: [f64; 2], value: f64| [least.min(value), most.max(value)];
    initial.iter().copied().chain(of_walls).fold([f64::INFINITY, f64::NEG_INFINITY], join)
}

/// Makes walls that hold a temperature impose its potential, which is what the operator acts on: a ghost
/// of the potential 2 psi(T) - psi behind the wall leaves T in it whatever the conductivities are.
///
/// # Errors
/// Convection and sources in proportion to the temperature, which are linear in that and not in the
/// potential; a wall that holds several materials.
pub(super) fn impose_potentials(problem: &mut Problem) -> Result<(), CaseError> {
    if !problem.has_curves() {
        return Ok(());
    }
    let refuse = |path: &str, reason: &str| {
        Err(CaseError::Thermal { path: path.to_owned(), reason: reason.to_owned() })
    };
    let conditions = problem.walls.iter().map(|wall| (&wall.name, &wall.condition));
    let surfaces = problem.surfaces.iter().map(|surface| (&surface.name, &surface.condition));
    if let Some((name, _)) =
        conditions.chain(surfaces).find(|(_, condition)| condition.kind == WallKind::Convection)
    {
        return refuse(
            name,
            "a convection wall needs materials whose conductivity does not depend on temperature and that \
             do not melt; give the flux, or hold the temperature",
        );
    }
    let grows = |source: &&crate::model::Source| source.linear.as_constant() != Some(0.0);
    if let Some(source) = problem.sources.iter().find(grows) {
        return refuse(
            &source.name,
            "a source in proportion to the temperature needs materials whose conductivity does not depend on \
             temperature and that do not melt",
        );
    }
    let (domain, cutoff) = (problem.domain, problem.kernel.cutoff());
    let particles = &problem.particles;
    for wall in &mut problem.walls {
        if wall.condition.kind != WallKind::Value {
            continue;
        }
        let near = particles.position.iter().zip(&particles.material);
        let mut near =
            near.filter(|(x, _)| wall.face.distance(&domain, **x) < cutoff).map(|(_, m)| *m);
        let Some(first) = near.next() else {
            continue;
        };
        let first = &problem.materials[usize::from(first)];
        if near.any(|material| !problem.materials[usize::from(material)].shares_curve(first)) {
            return refuse(
                &wall.name,
                "a wall that holds the temperature of several materials, of which one's conductivity depends \
                 on temperature or which melts: hold particles instead",
            );
        }
        let Some(curve) = first.curve.clone() else {
            continue;
        };
        let temperature = wall.condition.imposed.clone();
        let depends = [temperature.depends_on_position(), temperature.depends_on_time()];
        let text = temperature.text().to_owned();
        let potential = move |x, t| curve.potential_at(temperature.at(x, t));
        wall.condition.imposed =
            ScalarField::new(text, potential).depending_on(depends[0], depends[1]);
    }
    Ok(())
}

/// Refuses contact resistances where nobody knows where materials meet, or what conducts changes.
pub(super) fn check_contacts(problem: &Problem) -> Result<(), CaseError> {
    if problem.contacts.is_empty() {
        return Ok(());
    }
    let refuse = |reason: &str| {
        Err(CaseError::Thermal { path: "contacts".to_owned(), reason: reason.to_owned() })
    };
    if problem.has_curves() {
        return refuse(
            "a contact resistance needs materials whose conductivity does not depend on temperature and that do \
             not melt",
        );
    }
    if sites_with_particles(problem).is_none() {
        return refuse(
            "the particles are on no common lattice: let all fills begin whole spacings apart, so that it is known \
             where materials meet",
        );
    }
    Ok(())
}
