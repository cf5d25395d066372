//! The typed case to a [`Scene`]: numbers, shapes and particles, and every check.

use glam::DVec3;

use super::boundary::{hold, periodic};
use super::error::{CaseError, nearest};
use super::exact::{Setting, resolve as resolve_exact};
use super::fill::{Fill, Lattice};
use super::initial::{Ground, Initial, resolve as resolve_initial};
use super::number::{AXES, Evaluator, Field, in_range, show};
use super::schema::Case;
use super::shape::ShapeSpec;
use super::{OutputField, Scene};
use crate::model::integrator::Method;
use crate::model::kernel::SUPPORT_MARGIN;
use crate::model::{
    Correction, Domain, Kernel, KernelKind, Material, PairMean, Particles, Probe, Problem,
    StepChoice, TimePlan,
};

/// Relative error below which a length counts as a whole number of spacings, and a support as no
/// wider than half an axis.
const WHOLE: f64 = 1e-9;

/// How many particles an exact expression is tried at.
const TRIALS: usize = 1000;

/// Builds the scene; `warnings` are those so far.
pub(super) fn build(
    name: &str,
    mut case: Case,
    mut warnings: Vec<String>,
) -> Result<Scene, CaseError> {
    let evaluator = evaluator(&case)?;
    let spacing = evaluator.spacing.unwrap_or_default();
    let materials = materials(&case, &evaluator)?;
    let (domain, particles) = particles(&case, &evaluator, spacing, &mut warnings)?;
    let kernel = kernel(&case, &evaluator, spacing, &domain)?;
    let ground = Ground {
        evaluator: &evaluator,
        domain: &domain,
        spacing,
        particles: &particles,
    };
    let Initial {
        value: mut initial,
        deposits,
        recipients,
    } = resolve_initial(&case.initial, &ground)?;
    let held = hold(
        &case.boundaries,
        &evaluator,
        &particles,
        spacing,
        &mut initial,
    )?;
    for (particle, entry) in recipients {
        if held.binary_search(&particle).is_ok() {
            let x = show(particles.position[particle as usize], evaluator.dimension);
            warnings.push(format!(
                "initial[{entry}]: the particle at {x} is held: its part is lost"
            ));
        }
    }
    let time = time(&case, &evaluator)?;
    let setting = Setting {
        evaluator: &evaluator,
        domain: &domain,
        spacing,
        materials: &materials,
        deposits: &deposits,
    };
    let exact = case
        .exact
        .as_ref()
        .map(|spec| resolve_exact(spec, &setting))
        .transpose()?;
    if let Some((_, Some(field))) = &exact {
        try_out(field, &particles.position, time.end)?;
    }
    let probes = probes(&case, &evaluator, &domain, spacing)?;
    fill_in_defaults(&mut case);
    let fields = fields(&case)?;
    let resolved = serde_json::to_value(&case).map_err(|error| CaseError::Json {
        path: String::new(),
        reason: error.to_string(),
    })?;
    let problem = Problem {
        dimension: evaluator.dimension,
        spacing,
        domain,
        particles,
        materials,
        kernel,
        pair_mean: by_name(
            "operator.pair_mean",
            &case.operator.pair_mean,
            &PairMean::ALL,
            PairMean::name,
        )?,
        correction: by_name(
            "operator.correction",
            &case.operator.correction,
            &Correction::ALL,
            Correction::name,
        )?,
        initial,
        held,
        time,
        probes,
    };
    let exact = exact.map(|(solution, _)| solution);
    Ok(Scene {
        name: name.to_owned(),
        title: case.title,
        problem,
        exact,
        fields,
        resolved,
        warnings,
    })
}

/// The entry of `all` that `text` names.
fn by_name<T: Copy>(
    path: &str,
    text: &str,
    all: &[T],
    name: impl Fn(T) -> &'static str,
) -> Result<T, CaseError> {
    all.iter()
        .copied()
        .find(|&entry| name(entry) == text)
        .ok_or_else(|| {
            let known: Vec<String> = all.iter().map(|&entry| name(entry).to_owned()).collect();
            let nearest = nearest(text, &known, 1);
            CaseError::UnknownName {
                path: path.to_owned(),
                text: text.to_owned(),
                nearest,
                known,
            }
        })
}

fn evaluator(case: &Case) -> Result<Evaluator, CaseError> {
    let value = f64::from(case.dimension);
    in_range(
        "dimension",
        value,
        (1..=3).contains(&case.dimension),
        "1, 2 or 3",
    )?;
    let bare = Evaluator {
        dimension: case.dimension as usize,
        spacing: None,
    };
    let spacing = bare.positive("particles.spacing", &case.particles.spacing)?;
    Ok(Evaluator {
        spacing: Some(spacing),
        ..bare
    })
}

fn materials(case: &Case, evaluator: &Evaluator) -> Result<Vec<Material>, CaseError> {
    let count = case.materials.len();
    // Particles name their material by a u16.
    in_range(
        "materials",
        count as f64,
        count <= usize::from(u16::MAX),
        "at most 65535 materials",
    )?;
    let material = |(name, spec): (&String, &super::schema::MaterialSpec)| {
        let path = format!("materials.{name}");
        Ok(Material {
            name: name.clone(),
            diffusivity: evaluator.positive(&format!("{path}.diffusivity"), &spec.diffusivity)?,
            density: evaluator.positive(&format!("{path}.density"), &spec.density)?,
        })
    };
    case.materials.iter().map(material).collect()
}

fn particles(
    case: &Case,
    evaluator: &Evaluator,
    spacing: f64,
    warnings: &mut Vec<String>,
) -> Result<(Domain, Particles), CaseError> {
    let fills = fills(case, evaluator)?;
    let Some(first) = fills.first() else {
        return Err(CaseError::MissingKey {
            path: "particles.fill[0]".to_owned(),
        });
    };
    let origin = first.bounds.0;
    let (min, max) = fills.iter().fold(first.bounds, |all, fill| {
        (all.0.min(fill.bounds.0), all.1.max(fill.bounds.1))
    });
    let periodic = periodic(&case.boundaries, evaluator.dimension)?;
    let domain = Domain { min, max, periodic };
    check_whole(case, evaluator, &domain, &fills, warnings)?;
    let lattice = Lattice {
        origin,
        spacing,
        dimension: evaluator.dimension,
    };
    let particles = lattice.fill(&fills)?;
    Ok((domain, particles))
}

fn fills(case: &Case, evaluator: &Evaluator) -> Result<Vec<Fill>, CaseError> {
    let names: Vec<&String> = case.materials.keys().collect();
    let fill = |(index, spec): (usize, &super::schema::FillSpec)| {
        let path = format!("particles.fill[{index}]");
        let shape_path = format!("{path}.shape");
        let shape = spec.shape.resolve(evaluator, &shape_path)?;
        let bounds = shape
            .bounds()
            .ok_or(CaseError::Unbounded { path: shape_path })?;
        let material = names
            .iter()
            .position(|name| **name == spec.material)
            .ok_or_else(|| {
                let known: Vec<String> = names.iter().map(|&name| name.clone()).collect();
                let nearest = nearest(&spec.material, &known, 1);
                let (path, text) = (format!("{path}.material"), spec.material.clone());
                CaseError::UnknownName {
                    path,
                    text,
                    nearest,
                    known,
                }
            })?;
        Ok(Fill {
            path,
            shape,
            bounds,
            material: material as u16,
        })
    };
    case.particles.fill.iter().enumerate().map(fill).collect()
}

/// Periodic axes must be whole multiples of the spacing; a box that is not one is worth a warning.
fn check_whole(
    case: &Case,
    evaluator: &Evaluator,
    domain: &Domain,
    fills: &[Fill],
    warnings: &mut Vec<String>,
) -> Result<(), CaseError> {
    let spacing = evaluator.spacing.unwrap_or_default();
    let whole = |extent: f64| {
        let count = extent / spacing;
        (count - count.round()).abs() <= WHOLE * count.max(1.0)
    };
    for axis in 0..evaluator.dimension {
        let extent = domain.extent()[axis];
        if domain.periodic[axis] && !whole(extent) {
            let fits = extent / (extent / spacing).round().max(1.0);
            let path = "particles.spacing".to_owned();
            return Err(CaseError::NotWhole {
                path,
                spacing,
                axis: AXES[axis],
                extent,
                fits,
            });
        }
        for (fill, spec) in fills.iter().zip(&case.particles.fill) {
            let extent = (fill.bounds.1 - fill.bounds.0)[axis];
            let is_box = matches!(spec.shape, ShapeSpec::Box { .. });
            if is_box && !domain.periodic[axis] && !whole(extent) {
                warnings.push(format!(
                    "{}.shape.box: its {extent} m along {} are no whole number of spacings of \
                     {spacing} m",
                    fill.path, AXES[axis]
                ));
            }
        }
    }
    Ok(())
}

fn kernel(
    case: &Case,
    evaluator: &Evaluator,
    spacing: f64,
    domain: &Domain,
) -> Result<Kernel, CaseError> {
    let path = "kernel.support_ratio";
    let kind = by_name(
        "kernel.name",
        &case.kernel.name,
        &KernelKind::ALL,
        KernelKind::name,
    )?;
    let ratio = evaluator.number(path, &case.kernel.support_ratio)?;
    // At 1 and below no particle of a lattice has a neighbour.
    in_range(path, ratio, ratio * SUPPORT_MARGIN > 1.0, "above 1")?;
    let support_radius = ratio * spacing;
    let dimension = evaluator.dimension;
    for axis in (0..dimension).filter(|&axis| domain.periodic[axis]) {
        let extent = domain.extent()[axis];
        if 2.0 * support_radius > extent * (1.0 + WHOLE) {
            let (path, axis) = (path.to_owned(), AXES[axis]);
            return Err(CaseError::SupportTooWide {
                path,
                support_radius,
                axis,
                extent,
            });
        }
    }
    Kernel::new(kind, dimension, support_radius).ok_or_else(|| CaseError::KernelDimension {
        path: "kernel.name".to_owned(),
        kernel: kind.name(),
        dimension,
    })
}

fn time(case: &Case, evaluator: &Evaluator) -> Result<TimePlan, CaseError> {
    let end = evaluator.not_negative("time.end", &case.time.end)?;
    let step = match &case.time.step {
        None => StepChoice::Automatic,
        Some(number) => {
            let step = evaluator.positive("time.step", number)?;
            let requirement = format!("at most time.end, {end}");
            StepChoice::Given(in_range("time.step", step, step <= end, &requirement)?)
        }
    };
    let method = by_name("time.method", &case.time.method, &Method::ALL, Method::name)?;
    let every = |key: &str, number: &Option<super::number::Number>, default: f64| match number {
        None => Ok(default),
        Some(number) => evaluator.positive(&format!("output.{key}"), number),
    };
    let output_every = every("every", &case.output.every, end)?;
    let probe_every = every("probe_every", &case.output.probe_every, output_every)?;
    Ok(TimePlan {
        end,
        step,
        method,
        output_every,
        probe_every,
    })
}

/// An exact expression must be finite at the end; a sample of the particles shows whether it is.
fn try_out(field: &Field, position: &[DVec3], end: f64) -> Result<(), CaseError> {
    let stride = position.len().div_ceil(TRIALS).max(1);
    position
        .iter()
        .step_by(stride)
        .try_for_each(|&x| field.at(x, end).map(|_| ()))
}

fn probes(
    case: &Case,
    evaluator: &Evaluator,
    domain: &Domain,
    spacing: f64,
) -> Result<Vec<Probe>, CaseError> {
    let mut probes: Vec<Probe> = Vec::new();
    for (index, spec) in case.probes.iter().enumerate() {
        let path = format!("probes[{index}].at");
        let at = evaluator.point(&path, &spec.at)?;
        check_inside(&path, at, domain, evaluator, spacing)?;
        if probes.iter().any(|probe| probe.name == spec.name) {
            let path = format!("probes[{index}].name");
            return Err(CaseError::Duplicate {
                path,
                text: spec.name.clone(),
            });
        }
        probes.push(Probe {
            name: spec.name.clone(),
            at,
        });
    }
    Ok(probes)
}

/// Refuses a point outside the domain.
pub(super) fn check_inside(
    path: &str,
    at: DVec3,
    domain: &Domain,
    evaluator: &Evaluator,
    spacing: f64,
) -> Result<(), CaseError> {
    let tolerance = DVec3::splat(super::fill::TOLERANCE * spacing);
    let inside = at.cmpge(domain.min - tolerance) & at.cmple(domain.max + tolerance);
    if inside.all() {
        return Ok(());
    }
    let text = |x| show(x, evaluator.dimension);
    let (min, max) = (text(domain.min), text(domain.max));
    Err(CaseError::OutsideDomain {
        path: path.to_owned(),
        point: text(at),
        min,
        max,
    })
}

/// Writes down what the file leaves to defaults, so that a later change of a default does not
/// change what the resolved case means.
fn fill_in_defaults(case: &mut Case) {
    let output = &mut case.output;
    if output.every.is_none() && !super::unused::is_zero(&case.time.end) {
        output.every = Some(case.time.end.clone());
    }
    if output.probe_every.is_none() && !case.probes.is_empty() {
        output.probe_every.clone_from(&output.every);
    }
    if output.fields.is_none() {
        let with_exact = [OutputField::Value, OutputField::Exact, OutputField::Error];
        let count = if case.exact.is_some() { 3 } else { 1 };
        output.fields = Some(with_exact[..count].to_vec());
    }
}

/// The fields to write, none twice.
fn fields(case: &Case) -> Result<Vec<OutputField>, CaseError> {
    let fields = case.output.fields.clone().unwrap_or_default();
    for (index, field) in fields.iter().enumerate() {
        if fields[..index].contains(field) {
            let path = format!("output.fields[{index}]");
            return Err(CaseError::Duplicate {
                path,
                text: format!("{field:?}").to_lowercase(),
            });
        }
    }
    Ok(fields)
}
