//! What errors are against: the exact solution, or the finest run at the probes.

use crate::report::StudyReport;
use crate::report::run::{ErrorReport, ProbeReport};
use crate::report::study::{Measured, Point};

/// Says what the errors are against; where the case has no exact solution, fills them in against the
/// finest run, at the probes.
pub(super) fn compare(report: &mut StudyReport) {
    let named = report.measured().find_map(|(_, of)| of.error.as_ref());
    if let Some(error) = named {
        let several = report
            .measured()
            .any(|(_, of)| of.error.as_ref().is_some_and(|other| other.against != error.against));
        let and = if several { " and others: see the table of points in study.json" } else { "" };
        report.against = Some(format!("against the exact solution {}{and}", error.against));
        return;
    }
    let Some(finest) = finest(report) else { return };
    let (number, label) = (finest.0.number, finest.0.label.clone());
    let reference = finest.1.probes.clone();
    for point in &mut report.points {
        // The finest has no error of its own: it is what the others are compared with.
        let of = point.result.as_mut().filter(|_| point.number != number);
        if let Some(of) = of {
            of.error = against(&of.probes, &reference);
        }
    }
    report.against = Some(format!(
        "against the finest run, number {number} ({label}), at its {} probes alone, since the case has \
         no exact solution",
        reference.len()
    ));
}

/// The run of the least spacing, and of these the one of the most operator applications, if it has
/// probes.
fn finest(report: &StudyReport) -> Option<(&Point, &Measured)> {
    let with_probes = report.measured().filter(|(_, of)| !of.probes.is_empty());
    with_probes.min_by(|a, b| {
        let by_spacing = a.0.spacing.total_cmp(&b.0.spacing);
        by_spacing.then(b.1.operator_applications.cmp(&a.1.operator_applications))
    })
}

/// The norms of the difference at the probes that both have, each counted once.
fn against(values: &[ProbeReport], reference: &[ProbeReport]) -> Option<ErrorReport> {
    let pairs: Vec<(f64, f64)> = reference
        .iter()
        .filter_map(|of| {
            let same = values.iter().find(|probe| probe.name == of.name)?;
            Some((same.value, of.value))
        })
        .collect();
    if pairs.is_empty() {
        return None;
    }
    let (values, exact): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
    let norms = crate::report::Norms::new(&values, &exact, &vec![1.0; values.len()]);
    Some(ErrorReport::new("the finest run, at the probes", norms))
}
