//! Keys that nothing in the case uses.

use serde_json::Value;

use super::OutputField;
use super::error::CaseError;
use super::number::{Evaluator, Number};
use super::overrides::Override;
use super::parse::read;
use super::schema::{Case, TimeSpec};
use crate::model::integrator::Method;

#[derive(PartialEq)]
struct Unused {
    path: String,
    reason: &'static str,
}

/// Takes the keys that nothing uses out of `case`. One that an override made unused is a warning;
/// one that the file or an override itself has to no use is an error.
pub(super) fn remove(
    case: &mut Case,
    original: &Value,
    overrides: &[Override],
) -> Result<Vec<String>, CaseError> {
    let sets = |path: &str| {
        let below = format!("{path}.");
        overrides.iter().any(|entry| entry.path == path || entry.path.starts_with(&below))
    };
    // Of two that exclude each other, the one from the command line stands.
    let keeps_step = sets("time.step") && !sets("time.tolerance");
    let found = take_out(case, keeps_step);
    if found.is_empty() {
        return Ok(Vec::new());
    }
    let before = match read(original) {
        Ok(mut case) if !overrides.is_empty() => take_out(&mut case, keeps_step),
        _ => {
            return found.into_iter().next().map_or(Ok(Vec::new()), |unused| Err(unused.error()));
        }
    };
    let mut warnings = Vec::new();
    for unused in found {
        if before.contains(&unused) || sets(&unused.path) {
            return Err(unused.error());
        }
        warnings.push(unused.error().to_string());
    }
    Ok(warnings)
}

impl Unused {
    fn error(self) -> CaseError {
        CaseError::UnusedKey { path: self.path, reason: self.reason.to_owned() }
    }
}

fn take_out(case: &mut Case, keeps_step: bool) -> Vec<Unused> {
    let mut found = Vec::new();
    let mut drop = |path: String, reason: &'static str| found.push(Unused { path, reason });
    let fills = &case.particles.fill;
    case.materials.retain(|name, _| {
        // A case without fills has another fault, which is found later.
        let used = fills.is_empty() || fills.iter().any(|fill| fill.material == *name);
        if !used {
            drop(format!("materials.{name}"), "no fill is made of it");
        }
        used
    });
    let needs_exact =
        |field: &OutputField| matches!(field, OutputField::Exact | OutputField::Error);
    if let Some(fields) = &mut case.output.fields
        && case.exact.is_none()
        && fields.iter().any(needs_exact)
    {
        drop("output.fields".to_owned(), "exact and error need an exact solution");
        fields.retain(|field| !needs_exact(field));
    }
    if case.probes.is_empty() && case.output.probe_every.take().is_some() {
        drop("output.probe_every".to_owned(), "there are no probes");
    }
    take_out_of_time(&mut case.time, keeps_step, &mut drop);
    if is_zero(&case.time.end) {
        let nothing_integrated = "time.end is 0, so that nothing is integrated";
        if case.time.step.take().is_some() {
            drop("time.step".to_owned(), nothing_integrated);
        }
        if case.time.tolerance.take().is_some() {
            drop("time.tolerance".to_owned(), nothing_integrated);
        }
        if case.output.every.take().is_some() {
            drop("output.every".to_owned(), nothing_integrated);
        }
        if case.output.probe_every.take().is_some() {
            drop("output.probe_every".to_owned(), nothing_integrated);
        }
    }
    found
}

/// The keys of `time` that the method does not use.
fn take_out_of_time(
    time: &mut TimeSpec,
    keeps_step: bool,
    drop: &mut impl FnMut(String, &'static str),
) {
    let method = Method::ALL.into_iter().find(|method| method.name() == time.method);
    let has_estimate = method.is_none_or(Method::has_estimate);
    let is_implicit = method.is_none_or(Method::is_implicit);
    let is_steady = method == Some(Method::Steady);
    let mut take = |is_some: bool, key: &str, reason| {
        if is_some {
            drop(format!("time.{key}"), reason);
        }
    };
    if is_steady {
        let reason = "the method steady takes no steps";
        take(time.step.take().is_some(), "step", reason);
        take(time.tolerance.take().is_some(), "tolerance", reason);
        take(!std::mem::take(&mut time.breaks).is_empty(), "breaks", reason);
    } else if !has_estimate {
        let reason = "the method euler has no estimate of its error";
        take(time.tolerance.take().is_some(), "tolerance", reason);
    }
    if time.step.is_some() && time.tolerance.is_some() {
        if keeps_step {
            time.tolerance = None;
            take(true, "tolerance", "a step is given");
        } else {
            time.step = None;
            take(true, "step", "a tolerance is given");
        }
    }
    let solves_to_tolerance = !is_steady && time.step.is_none();
    if (!is_implicit || solves_to_tolerance) && time.linear_tolerance.take().is_some() {
        let reason = match is_implicit {
            true => "linear systems are solved as well as the tolerance needs",
            false => "the method solves no linear system",
        };
        take(true, "linear_tolerance", reason);
    }
    if !is_implicit && time.preconditioner.take().is_some() {
        take(true, "preconditioner", "the method solves no linear system");
    }
}

pub(super) fn is_zero(number: &Number) -> bool {
    let evaluator = Evaluator { dimension: 1, spacing: Some(1.0) };
    evaluator.number("time.end", number).is_ok_and(|value| value == 0.0)
}
