//! The typed case to a [`Scene`].

use glam::DVec3;

use super::Scene;
use super::boundary::hold;
use super::error::{CaseError, nearest};
use super::exact::{Setting, resolve as resolve_exact};
use super::geometry::{WHOLE, particles};
use super::initial::{Ground, Initial, Recipient, resolve as resolve_initial};
use super::material::{MaterialSpec, material_index};
use super::number::{AXES, Evaluator, Field, in_range, show};
use super::plan::{fields, fill_in_defaults, probes, time};
use super::schema::Case;
use super::source::resolve as resolve_sources;
use super::thermal::{check_contacts, impose_potentials, range_of_values};
use super::wall::{Body, resolve as resolve_walls};
use crate::exact::Solution;
use crate::model::integrator::{Method, MethodChoice};
use crate::model::kernel::SUPPORT_MARGIN;
use crate::model::operator::ContactResistance;
use crate::model::{
    Correction, Domain, Kernel, KernelKind, Material, PairMean, Particles, Problem,
};

/// The largest support ratio: half a million neighbours in 3-D.
const WIDEST: f64 = 50.0;

/// How many particles an exact expression is tried at.
const TRIALS: usize = 1000;

/// Builds the scene; `warnings` are those so far.
pub(super) fn build(
    name: &str,
    mut case: Case,
    mut warnings: Vec<String>,
) -> Result<Scene, CaseError> {
    let (problem, exact) = problem(&case, &mut warnings)?;
    fill_in_defaults(&mut case);
    let fields = fields(&case)?;
    let resolved = serde_json::to_value(&case)
        .map_err(|error| CaseError::Json { path: String::new(), reason: error.to_string() })?;
    let (name, title) = (name.to_owned(), case.title);
    Ok(Scene { name, title, problem, exact, fields, resolved, warnings })
}

fn problem(
    case: &Case,
    warnings: &mut Vec<String>,
) -> Result<(Problem, Option<Solution>), CaseError> {
    let (evaluator, spacing) = evaluator(case)?;
    // Temperatures are not known yet, and properties that depend on them not needed.
    let materials = resolve_materials(case, &evaluator, None)?;
    warn_of_mixed_units(case, warnings);
    let (domain, particles) = particles(case, &evaluator, spacing, warnings)?;
    let kernel = kernel(case, &evaluator, spacing, &domain)?;
    let body = Body {
        evaluator: &evaluator,
        domain: &domain,
        spacing,
        kernel: &kernel,
        particles: &particles,
    };
    let (walls, surfaces) = resolve_walls(&case.boundaries, &body, warnings)?;
    let (pair_mean, correction) = operator(case)?;
    let ground = Ground {
        evaluator: &evaluator,
        domain: &domain,
        spacing,
        particles: &particles,
        materials: &materials,
    };
    let mut initial = resolve_initial(&case.initial, &ground)?;
    let held = hold(&case.boundaries, &evaluator, &particles, spacing, &mut initial.value)?;
    let mut time = time(case, &evaluator)?;
    let sources = resolve_sources(&case.sources, &body, &held, time.end, warnings)?;
    time.breaks.extend(sources.breaks);
    time.breaks.sort_by(f64::total_cmp);
    time.breaks.dedup();
    warn_of_lost_parts(&initial, &held, &particles, &evaluator, warnings);
    let materials = if case.materials.values().any(MaterialSpec::depends_on_temperature) {
        let range = range_of_values(&initial.value, &walls, &domain);
        resolve_materials(case, &evaluator, Some(range))?
    } else {
        materials
    };
    let setting = Setting {
        evaluator: &evaluator,
        domain: &domain,
        spacing,
        materials: &materials,
        walls: &walls,
        sources: &case.sources,
        deposits: &initial.deposits,
    };
    let exact = solution(case, &setting, &particles.position, time.end)?;
    let mut problem = Problem {
        dimension: evaluator.dimension,
        spacing,
        domain,
        probes: probes(case, &evaluator, &domain, spacing)?,
        initial: initial.into_state(&particles, &materials, &held),
        particles,
        materials,
        kernel,
        pair_mean,
        contacts: contacts(case, &evaluator, pair_mean)?,
        correction,
        held,
        walls,
        surfaces,
        sources: sources.list,
        time,
    };
    check_preconditioner(case, &problem)?;
    impose_potentials(&mut problem)?;
    check_contacts(&problem)?;
    warn_of_growth(&problem, warnings);
    Ok((problem, exact))
}

/// Refuses a choice that steps do not have where heat is no straight function of temperature.
fn check_preconditioner(case: &Case, problem: &Problem) -> Result<(), CaseError> {
    let takes_steps = problem.time.method != MethodChoice::Given(Method::Steady);
    if case.time.preconditioner.is_none() || !problem.has_curves() || !takes_steps {
        return Ok(());
    }
    Err(CaseError::UnusedKey {
        path: "time.preconditioner".to_owned(),
        reason: "Newton's method, where something melts or conducts as its temperature, has the diagonal".to_owned(),
    })
}

fn operator(case: &Case) -> Result<(PairMean, Correction), CaseError> {
    let (mean, correction) = (&case.operator.pair_mean, &case.operator.correction);
    Ok((
        by_name("operator.pair_mean", mean, &PairMean::ALL, PairMean::name)?,
        by_name("operator.correction", correction, &Correction::ALL, Correction::name)?,
    ))
}

fn warn_of_lost_parts(
    initial: &Initial,
    held: &[u32],
    particles: &Particles,
    evaluator: &Evaluator,
    warnings: &mut Vec<String>,
) {
    for Recipient { particle, entry, .. } in &initial.recipients {
        if held.binary_search(particle).is_ok() {
            let x = show(particles.position[*particle as usize], evaluator.dimension);
            let fault = format!("the particle at {x} is held: its part of the amount is lost");
            warnings.push(format!("initial[{entry}]: {fault}"));
        }
    }
}

fn warn_of_growth(problem: &Problem, warnings: &mut Vec<String>) {
    let growth = problem.linear_sources().growth;
    if growth > 0.0 {
        warnings.push(format!(
            "sources: the value grows by itself by up to {growth:.3e} of it a second, by a factor of up to \
             {:.3e} until time.end, and so does every error in it",
            (growth * problem.time.end).exp()
        ));
    }
}

/// Where some materials have a diffusivity alone and others a conductivity.
fn warn_of_mixed_units(case: &Case, warnings: &mut Vec<String>) {
    let is_thermal = |spec: &MaterialSpec| spec.is_thermal();
    let mut thermal = case.materials.values().map(is_thermal);
    let first = thermal.next();
    if thermal.any(|other| Some(other) != first) {
        warnings.push(
            "materials: some have a diffusivity alone, which counts as a conductivity with a capacity of 1, \
             and some a conductivity in W/(m K): where they meet, units are mixed"
                .to_owned(),
        );
    }
}

fn solution(
    case: &Case,
    setting: &Setting,
    position: &[DVec3],
    end: f64,
) -> Result<Option<Solution>, CaseError> {
    let Some(spec) = &case.exact else {
        return Ok(None);
    };
    let (solution, expression) = resolve_exact(spec, setting)?;
    if !case.sources.is_empty() && !solution.allows_sources() {
        return Err(CaseError::ExactWithoutSources { name: solution.name() });
    }
    if let Some(field) = expression {
        try_out(&field, position, end)?;
    }
    Ok(Some(solution))
}

/// The entry of `all` that `text` names.
pub(super) fn by_name<T: Copy>(
    path: &str,
    text: &str,
    all: &[T],
    name: impl Fn(T) -> &'static str,
) -> Result<T, CaseError> {
    all.iter().copied().find(|&entry| name(entry) == text).ok_or_else(|| {
        let known: Vec<String> = all.iter().map(|&entry| name(entry).to_owned()).collect();
        let nearest = nearest(text, &known, 1);
        CaseError::UnknownName { path: path.to_owned(), text: text.to_owned(), nearest, known }
    })
}

/// What evaluates the case's numbers, and the spacing (m), which it knows too.
fn evaluator(case: &Case) -> Result<(Evaluator, f64), CaseError> {
    let value = f64::from(case.dimension);
    in_range("dimension", value, (1..=3).contains(&case.dimension), "1, 2 or 3")?;
    let bare = Evaluator { dimension: case.dimension as usize, spacing: None };
    let spacing = bare.positive("particles.spacing", &case.particles.spacing)?;
    Ok((Evaluator { spacing: Some(spacing), ..bare }, spacing))
}

/// What resists where materials meet.
fn contacts(
    case: &Case,
    evaluator: &Evaluator,
    pair_mean: PairMean,
) -> Result<Vec<ContactResistance>, CaseError> {
    let mut contacts: Vec<ContactResistance> = Vec::new();
    for (index, spec) in case.contacts.iter().enumerate() {
        let path = format!("contacts[{index}]");
        if pair_mean != PairMean::Harmonic {
            let reason = "a contact resistance needs the harmonic pair_mean".to_owned();
            return Err(CaseError::UnusedKey { path, reason });
        }
        let [one, other] = &spec.between[..] else {
            let reason = format!("expected two materials, found {}", spec.between.len());
            return Err(CaseError::WrongType { path: format!("{path}.between"), reason });
        };
        let material = |k: usize, name: &String| {
            let path = format!("{path}.between[{k}]");
            material_index(&path, name, case.materials.keys()).map(|index| index as u16)
        };
        let mut between = [material(0, one)?, material(1, other)?];
        between.sort_unstable();
        if between[0] == between[1] || contacts.iter().any(|contact| contact.between == between) {
            let text = format!("{one}, {other}");
            return Err(CaseError::Duplicate { path: format!("{path}.between"), text });
        }
        let resistance = evaluator.not_negative(&format!("{path}.resistance"), &spec.resistance)?;
        contacts.push(ContactResistance { between, resistance });
    }
    Ok(contacts)
}

/// The materials, with what depends on temperature for the temperatures of `range` (K) and far around.
fn resolve_materials(
    case: &Case,
    evaluator: &Evaluator,
    range: Option<[f64; 2]>,
) -> Result<Vec<Material>, CaseError> {
    let count = case.materials.len();
    // Particles name their material by a u16.
    in_range("materials", count as f64, count <= usize::from(u16::MAX), "at most 65535 materials")?;
    let material = |(name, spec): (&String, &MaterialSpec)| spec.resolve(name, evaluator, range);
    case.materials.iter().map(material).collect()
}

fn kernel(
    case: &Case,
    evaluator: &Evaluator,
    spacing: f64,
    domain: &Domain,
) -> Result<Kernel, CaseError> {
    let path = "kernel.support_ratio";
    let kind = by_name("kernel.name", &case.kernel.name, &KernelKind::ALL, KernelKind::name)?;
    let ratio = evaluator.number(path, &case.kernel.support_ratio)?;
    // At 1 and below no particle of a lattice has a neighbour.
    let allowed = ratio * SUPPORT_MARGIN > 1.0 && ratio <= WIDEST;
    in_range(path, ratio, allowed, &format!("above 1 and at most {WIDEST}"))?;
    let support_radius = ratio * spacing;
    let dimension = evaluator.dimension;
    check_support(path, support_radius, spacing, dimension, domain)?;
    Kernel::new(kind, dimension, support_radius).ok_or_else(|| CaseError::KernelDimension {
        path: "kernel.name".to_owned(),
        kernel: kind.name(),
        dimension,
    })
}

/// The support may not be wider than half of the shortest periodic axis.
fn check_support(
    path: &str,
    support_radius: f64,
    spacing: f64,
    dimension: usize,
    domain: &Domain,
) -> Result<(), CaseError> {
    let extents = domain.extent();
    let periodic = (0..dimension).filter(|&axis| domain.periodic[axis]);
    let Some(axis) = periodic.min_by(|&a, &b| extents[a].total_cmp(&extents[b])) else {
        return Ok(());
    };
    let extent = extents[axis];
    if 2.0 * support_radius <= extent * (1.0 + WHOLE) {
        return Ok(());
    }
    // A periodic axis is a whole number of spacings.
    let most = ((extent / spacing).round() / 2.0).min(WIDEST);
    let (path, axis) = (path.to_owned(), AXES[axis]);
    Err(CaseError::SupportTooWide { path, support_radius, most, axis, extent })
}

/// An exact expression must be finite at the end; a sample of the particles shows whether it is.
fn try_out(field: &Field, position: &[DVec3], end: f64) -> Result<(), CaseError> {
    let stride = position.len().div_ceil(TRIALS).max(1);
    position.iter().step_by(stride).try_for_each(|&x| field.at(x, end).map(|_| ()))
}
