//! The `particles` section: fills to a domain and its particles.

use super::boundary::periodic;
use super::error::CaseError;
use super::fill::{Fill, Lattice};
use super::material::material_index;
use super::number::{AXES, Evaluator};
use super::schema::{Case, FillSpec};
use super::shape::ShapeSpec;
use super::wall::walled_faces;
use crate::model::{Domain, Face, Particles};

/// Relative error below which a length counts as a whole number of spacings, and a support as no
/// wider than half an axis.
pub(super) const WHOLE: f64 = 1e-9;

/// The domain and its particles; a box that is no whole number of spacings is a warning.
pub(super) fn particles(
    case: &Case,
    evaluator: &Evaluator,
    spacing: f64,
    warnings: &mut Vec<String>,
) -> Result<(Domain, Particles), CaseError> {
    let fills = fills(case, evaluator)?;
    let Some(first) = fills.first() else {
        return Err(CaseError::MissingKey { path: "particles.fill[0]".to_owned() });
    };
    let origin = first.bounds.0;
    let (min, max) = fills
        .iter()
        .fold(first.bounds, |all, fill| (all.0.min(fill.bounds.0), all.1.max(fill.bounds.1)));
    let periodic = periodic(&case.boundaries, evaluator.dimension)?;
    let domain = Domain { min, max, periodic };
    check_whole(case, evaluator.dimension, spacing, &domain, &fills, warnings)?;
    let lattice = Lattice { origin, spacing, dimension: evaluator.dimension, domain };
    let particles = lattice.fill(&fills)?;
    Ok((domain, particles))
}

fn fills(case: &Case, evaluator: &Evaluator) -> Result<Vec<Fill>, CaseError> {
    let fill = |(index, spec): (usize, &FillSpec)| {
        let path = format!("particles.fill[{index}]");
        let shape_path = format!("{path}.shape");
        let shape = spec.shape.resolve(evaluator, &shape_path)?;
        let bounds = shape.bounds().ok_or(CaseError::Unbounded { path: shape_path })?;
        let names = case.materials.keys();
        let material = material_index(&format!("{path}.material"), &spec.material, names)?;
        Ok(Fill { path, shape, bounds, material: material as u16 })
    };
    case.particles.fill.iter().enumerate().map(fill).collect()
}

/// Periodic axes must be whole multiples of the spacing; a box that is not one is worth a warning,
/// and so is a walled axis.
fn check_whole(
    case: &Case,
    dimension: usize,
    spacing: f64,
    domain: &Domain,
    fills: &[Fill],
    warnings: &mut Vec<String>,
) -> Result<(), CaseError> {
    let whole = |extent: f64| {
        let count = extent / spacing;
        (count - count.round()).abs() <= WHOLE * count.abs().max(1.0)
    };
    let faces = walled_faces(&case.boundaries);
    for (axis, &name) in AXES.iter().enumerate().take(dimension) {
        let extent = domain.extent()[axis];
        if domain.periodic[axis] && !whole(extent) {
            let fits = extent / (extent / spacing).round().max(1.0);
            let path = "particles.spacing".to_owned();
            return Err(CaseError::NotWhole { path, spacing, axis: name, extent, fits });
        }
        // Next to a face between the lattice's cells, particles are not half a spacing away.
        let between = |face: &&Face| {
            face.axis == axis && !whole(face.coordinate(domain) - fills[0].bounds.0[axis])
        };
        let consequence = consequence(faces.iter().filter(between));
        let odd = |path: &str, extent: f64| {
            format!(
                "{path}: its {extent} m along {name} are no whole number of spacings of {spacing} \
                 m{consequence}"
            )
        };
        let before = warnings.len();
        for (fill, spec) in fills.iter().zip(&case.particles.fill) {
            let extent = (fill.bounds.1 - fill.bounds.0)[axis];
            let is_box = matches!(spec.shape, ShapeSpec::Box { .. });
            if is_box && !domain.periodic[axis] && !whole(extent) {
                warnings.push(odd(&format!("{}.shape.box", fill.path), extent));
            }
        }
        if warnings.len() == before && !consequence.is_empty() {
            warnings.push(odd("particles.fill", extent));
        }
    }
    Ok(())
}

/// What walled faces between the cells of the lattice mean, for a warning; empty without any.
fn consequence<'a>(faces: impl Iterator<Item = &'a Face>) -> String {
    let mut names: Vec<String> = faces.map(|&face| face.name().to_owned()).collect();
    names.sort();
    names.dedup();
    if names.is_empty() {
        return String::new();
    }
    format!("; next to the wall on {} the accuracy drops to first order", names.join(" and "))
}
