//! What the points of a study say together: orders, the Pareto front, which setting to run.

use crate::report::format::{significant, wall_time};
use crate::report::study::{Measured, Order, PeerPoint, Point, Recommendation, Slopes, TARGETS};
use crate::report::{StudyReport, observed_order};

/// Fills in what follows from the points.
pub(super) fn analyse(report: &mut StudyReport) {
    mark_front(report);
    report.orders = orders(report, "spacing", |point, _| Some(point.spacing));
    report.orders.extend(orders(report, "step", |_, of| of.dt));
    if !report.measured().any(|(_, of)| of.error.is_some()) {
        let why = "There is nothing to compare with: the case has no exact solution, and no two runs \
                   have a probe of one name.";
        report.remarks.push(why.to_owned());
        return;
    }
    report.recommendations = TARGETS.map(|target| recommend(report, target)).to_vec();
    report.peers_ahead = peers_ahead(report);
}

/// Marks the points that no other is both faster and more accurate than.
fn mark_front(report: &mut StudyReport) {
    let all: Vec<(usize, f64, f64)> = (report.measured())
        .filter_map(|(point, of)| Some((point.number, of.total_s.median, of.error_norm()?)))
        .collect();
    for point in &mut report.points {
        let own = all.iter().find(|of| of.0 == point.number);
        let is_beaten = |time: f64, error: f64| {
            let better =
                |&(_, t, e): &(usize, f64, f64)| t <= time && e <= error && (t < time || e < error);
            all.iter().any(better)
        };
        if let (Some(of), Some(&(_, time, error))) = (&mut point.result, own) {
            of.pareto = !is_beaten(time, error);
        }
    }
}

/// The orders of every series of points that differ in `varies` alone; `size` is what that is, m or
/// s.
fn orders(
    report: &StudyReport,
    varies: &str,
    size: impl Fn(&Point, &Measured) -> Option<f64>,
) -> Vec<Order> {
    let mut names: Vec<String> = Vec::new();
    let varied = report.measured().filter(|(point, _)| point.setting(varies).is_some());
    for (point, _) in varied {
        let name = point.series(varies);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let of_series = |series: String| {
        let is_it =
            |point: &Point| point.setting(varies).is_some() && point.series(varies) == series;
        let mut members: Vec<(f64, &Point, &Measured)> = (report.measured())
            .filter(|(point, of)| is_it(point) && of.error_norm().is_some())
            .filter_map(|(point, of)| Some((size(point, of)?, point, of)))
            .collect();
        members.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (from, to) = (members.first()?.0, members.last()?.0);
        if to <= from * (1.0 + 1e-9) {
            return None;
        }
        let all = slopes(&members);
        let finest = slopes(&members[..2]);
        let time_part = (varies == "step").then(|| time_order(&members)).flatten();
        let points = members.iter().map(|member| member.1.number).collect();
        Some(Order { varies: varies.to_owned(), series, points, from, to, all, finest, time_part })
    };
    names.into_iter().filter_map(of_series).collect()
}

/// The slopes of the error of `members`, by norm.
fn slopes(members: &[(f64, &Point, &Measured)]) -> Slopes {
    let slope = |norm: fn(&crate::report::run::ErrorReport) -> f64| {
        let errors: Option<Vec<f64>> =
            members.iter().map(|(_, _, of)| of.error.as_ref().map(norm)).collect();
        observed_order(&sizes(members), &errors?)
    };
    Slopes {
        l1: slope(|error| error.l1),
        l2: slope(|error| error.l2),
        linf: slope(|error| error.linf),
        l2_relative: slope(|error| error.l2_relative),
    }
}

/// The slope of what the steps make of the error at the first probe.
fn time_order(members: &[(f64, &Point, &Measured)]) -> Option<f64> {
    let part = |of: &Measured| Some(of.split.as_ref()?.probes.first()?.part("step")?.value.abs());
    let parts: Option<Vec<f64>> = members.iter().map(|(_, _, of)| part(of)).collect();
    observed_order(&sizes(members), &parts?)
}

fn sizes(members: &[(f64, &Point, &Measured)]) -> Vec<f64> {
    members.iter().map(|member| member.0).collect()
}

/// The cheapest point whose error is at most `target`.
fn recommend(report: &StudyReport, target: f64) -> Recommendation {
    let reaches = |of: &Measured| of.error_norm().is_some_and(|error| error <= target);
    let cheapest = (report.measured())
        .filter(|(_, of)| reaches(of))
        .min_by(|a, b| a.1.total_s.median.total_cmp(&b.1.total_s.median));
    let goal = format!("For a relative L2 error of {}", percent(target));
    let Some((point, of)) = cheapest else {
        let best = report.measured().filter_map(|(_, of)| of.error_norm()).reduce(f64::min);
        let best =
            best.map_or_else(String::new, |best| format!("; the least is {}", percent(best)));
        let text = format!("{goal}: no setting of this study reaches it{best}.");
        return Recommendation { target, point: None, total_s: None, text };
    };
    let total = of.total_s.median;
    let text = format!(
        "{goal}: {} (number {}), {} with {} of set-up, error {}.",
        point.label,
        point.number,
        wall_time(total),
        wall_time(of.setup_s.median),
        percent(of.error_norm().unwrap_or(f64::NAN))
    );
    Recommendation { target, point: Some(point.number), total_s: Some(total), text }
}

/// Where other programs win: for a target, or by an error that nothing here reaches as fast.
fn peers_ahead(report: &StudyReport) -> Vec<String> {
    let Some(peers) = &report.peers else { return Vec::new() };
    let mut said = Vec::new();
    for of in &report.recommendations {
        let reaches = peers.points.iter().filter(|peer| peer.l2_relative <= of.target);
        let fastest = reaches.min_by(|a, b| a.total_s().total_cmp(&b.total_s()));
        let Some(peer) = fastest else { continue };
        let took = wall_time(peer.total_s());
        let (name, goal) = (peer.name(), percent(of.target));
        match of.total_s {
            Some(own) if own <= peer.total_s() => said.push(format!(
                "{goal}: diffusph is {} times as fast as the fastest other program, {name} ({took}).",
                significant(peer.total_s() / own, 3)
            )),
            Some(own) => said.push(format!(
                "{goal}: {name} WINS, {took} against {}: {} times as fast.",
                wall_time(own),
                significant(own / peer.total_s(), 3)
            )),
            None => said.push(format!("{goal}: {name} WINS: {took}, where no setting here reaches it.")),
        }
    }
    let not_matched = |peer: &&PeerPoint| {
        !report.measured().any(|(_, of)| {
            let is_as_good = of.error_norm().is_some_and(|error| error <= peer.l2_relative);
            is_as_good && of.total_s.median <= peer.total_s()
        })
    };
    let ahead: Vec<String> = (peers.points.iter())
        .filter(not_matched)
        .map(|peer| {
            format!(
                "{}, {} to {}",
                peer.name(),
                wall_time(peer.total_s()),
                percent(peer.l2_relative)
            )
        })
        .collect();
    if !ahead.is_empty() {
        let ahead = ahead.join("; ");
        said.push(format!("No setting here is as fast and as accurate as: {ahead}."));
    }
    if !peers.points.is_empty() {
        said.push(format!("Other programs ran on: {}.", peers.machine));
    }
    said
}

fn percent(part: f64) -> String {
    format!("{} %", significant(100.0 * part, 3))
}

#[cfg(test)]
mod tests;
