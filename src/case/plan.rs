//! The `time`, `probes` and `output` sections.

use glam::DVec3;

use super::OutputField;
use super::build::by_name;
use super::error::CaseError;
use super::fill::TOLERANCE;
use super::material::MaterialSpec;
use super::number::{Evaluator, Number, in_range, show};
use super::schema::{Case, ToleranceSpec};
use super::unused::is_zero;
use crate::model::integrator::{MethodChoice, Preconditioner, Tolerance};
use crate::model::{Domain, Probe, StepChoice, TimePlan};

/// Relative error that a count of intervals may have.
const ROUND_OFF: f64 = 1e-9;

/// The most outputs of the fields.
const MOST_OUTPUTS: f64 = 1e5;

/// The most records of the probes.
const MOST_PROBE_OUTPUTS: f64 = 1e7;

/// The most steps: f64 counts exactly up to 9e15.
const MOST_STEPS: f64 = 1e15;

/// Duration, step, method and output times.
pub(super) fn time(case: &Case, evaluator: &Evaluator) -> Result<TimePlan, CaseError> {
    let end = evaluator.not_negative("time.end", &case.time.end)?;
    let step = match (&case.time.step, &case.time.tolerance) {
        (None, None) => StepChoice::Automatic,
        (None, Some(spec)) => StepChoice::Tolerance(tolerance(spec, evaluator)?),
        (Some(number), _) => {
            let step = evaluator.positive("time.step", number)?;
            let requirement = format!("at most time.end, {end}");
            in_range("time.step", step, step <= end, &requirement)?;
            StepChoice::Given(not_too_often("time.step", step, end, MOST_STEPS, "steps")?)
        }
    };
    let all = MethodChoice::all();
    let method = by_name("time.method", &case.time.method, &all, MethodChoice::name)?;
    let breaks = breaks(&case.time.breaks, evaluator, end)?;
    let linear_tolerance = match &case.time.linear_tolerance {
        None => None,
        Some(number) => Some(part("time.linear_tolerance", number, evaluator)?),
    };
    let preconditioner = match &case.time.preconditioner {
        None => Preconditioner::TwoLevel,
        Some(name) => {
            let all = &Preconditioner::ALL;
            by_name("time.preconditioner", name, all, Preconditioner::name)?
        }
    };
    let every = |path: &str, number: &Option<Number>, default: f64, most: f64| match number {
        None => Ok(default),
        Some(number) => {
            not_too_often(path, evaluator.positive(path, number)?, end, most, "outputs")
        }
    };
    let output = &case.output;
    let output_every = every("output.every", &output.every, end, MOST_OUTPUTS)?;
    let path = "output.probe_every";
    let probe_every = every(path, &output.probe_every, output_every, MOST_PROBE_OUTPUTS)?;
    Ok(TimePlan {
        end,
        step,
        method,
        breaks,
        linear_tolerance,
        preconditioner,
        output_every,
        probe_every,
    })
}

fn tolerance(spec: &ToleranceSpec, evaluator: &Evaluator) -> Result<Tolerance, CaseError> {
    let absolute = match &spec.absolute {
        None => 0.0,
        Some(number) => evaluator.positive("time.tolerance.absolute", number)?,
    };
    let relative = match &spec.relative {
        None => 0.0,
        Some(number) => part("time.tolerance.relative", number, evaluator)?,
    };
    let is_some = absolute > 0.0 || relative > 0.0;
    in_range("time.tolerance", 0.0, is_some, "absolute or relative, or both")?;
    Ok(Tolerance { absolute, relative })
}

/// A number above 0 and below 1.
fn part(path: &str, number: &Number, evaluator: &Evaluator) -> Result<f64, CaseError> {
    let value = evaluator.positive(path, number)?;
    in_range(path, value, value < 1.0, "below 1")
}

/// Times within the run, ascending.
fn breaks(numbers: &[Number], evaluator: &Evaluator, end: f64) -> Result<Vec<f64>, CaseError> {
    let mut times: Vec<f64> = Vec::with_capacity(numbers.len());
    for (index, number) in numbers.iter().enumerate() {
        let path = format!("time.breaks[{index}]");
        let time = evaluator.positive(&path, number)?;
        in_range(&path, time, time < end, &format!("before time.end, {end}"))?;
        let is_later = times.last().is_none_or(|&last| time > last);
        in_range(&path, time, is_later, "later than the one before")?;
        times.push(time);
    }
    Ok(times)
}

/// `interval` (s) if at most `most` of it fit into the time up to the end.
fn not_too_often(
    path: &str,
    interval: f64,
    end: f64,
    most: f64,
    what: &str,
) -> Result<f64, CaseError> {
    let count = end / interval;
    let least = end / most;
    let requirement =
        format!("at least {least} (there would be {count:.3e} {what}, at most {most} are allowed)");
    in_range(path, interval, count <= most * (1.0 + ROUND_OFF), &requirement)
}

/// The probes: inside the domain, no name twice.
pub(super) fn probes(
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
            return Err(CaseError::Duplicate { path, text: spec.name.clone() });
        }
        probes.push(Probe { name: spec.name.clone(), at });
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
    let tolerance = DVec3::splat(TOLERANCE * spacing);
    let inside = at.cmpge(domain.min - tolerance) & at.cmple(domain.max + tolerance);
    if inside.all() {
        return Ok(());
    }
    let text = |x| show(x, evaluator.dimension);
    let (min, max) = (text(domain.min), text(domain.max));
    Err(CaseError::OutsideDomain { path: path.to_owned(), point: text(at), min, max })
}

/// Writes down what the file leaves to defaults, so that a later change of a default does not
/// change what the resolved case means.
pub(super) fn fill_in_defaults(case: &mut Case) {
    case.materials.values_mut().for_each(MaterialSpec::fill_in_defaults);
    let time = &mut case.time;
    let follows = ["heun", "rkl2", "tr_bdf2", MethodChoice::AUTO].contains(&time.method.as_str());
    if follows && time.step.is_none() && time.tolerance.is_none() && !is_zero(&time.end) {
        let relative = Some(Tolerance::DEFAULT.relative.into());
        time.tolerance = Some(ToleranceSpec { absolute: None, relative });
    }
    let output = &mut case.output;
    if output.every.is_none() && !is_zero(&case.time.end) {
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
pub(super) fn fields(case: &Case) -> Result<Vec<OutputField>, CaseError> {
    let fields = case.output.fields.clone().unwrap_or_default();
    for (index, field) in fields.iter().enumerate() {
        if fields[..index].contains(field) {
            let path = format!("output.fields[{index}]");
            return Err(CaseError::Duplicate { path, text: format!("{field:?}").to_lowercase() });
        }
    }
    Ok(fields)
}
