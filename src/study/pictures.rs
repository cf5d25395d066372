//! What a run draws: the profile, the front and the probes.

use glam::DVec3;

use super::recorder::Recorder;
use crate::case::Scene;
use crate::exact::Solution;
use crate::model::Problem;
use crate::report::format::simulated_time;
use crate::report::run::Front;
use crate::report::{
    Along, History, HistoryPlot, OutputError, OutputFolder, Profile, Trace, total,
};

/// Points of the exact curve of a plot.
const CURVE_POINTS: usize = 600;

/// The least readings of a probe that are drawn.
const LEAST_READINGS: u64 = 3;

/// Names of values and temperatures in plots.
const VALUE: &str = "value";
const TEMPERATURE: &str = "temperature (K)";

/// Draws what there is to draw of a run. No time passes on the way to a steady state: then there are
/// no histories.
pub(super) fn write(
    scene: &Scene,
    recorder: &Recorder<'_>,
    exact: Option<&[f64]>,
    folder: &OutputFolder,
    is_steady: bool,
) -> Result<(), OutputError> {
    if let Some(profile) = profile(scene, recorder, exact) {
        profile.write(folder.path())?;
    }
    if is_steady {
        return Ok(());
    }
    if let Some(plot) = front_plot(scene, recorder) {
        plot.write(folder.path(), "front.svg")?;
    }
    if let Some(plot) = probe_plot(scene, recorder) {
        plot.write(folder.path(), "probes.svg")?;
    }
    Ok(())
}

/// How far a scene has melted; `None` where nothing can.
pub(super) fn front(scene: &Scene, state: &[f64], time: f64) -> Option<Front> {
    let problem = &scene.problem;
    if !problem.melts() {
        return None;
    }
    let volume = &problem.particles.volume;
    let liquid =
        |particle: usize| volume[particle] * problem.liquid_fraction(particle, state[particle]);
    let melted: Vec<f64> = (0..state.len()).map(liquid).collect();
    let section: f64 = problem.domain.extent().to_array()[1..problem.dimension].iter().product();
    let liquid_volume = total(&melted, &vec![1.0; melted.len()]);
    Some(Front::new(liquid_volume, section, exact_front(scene, time)))
}

fn exact_front(scene: &Scene, time: f64) -> Option<f64> {
    scene.exact.as_ref()?.liquid_depth(time, scene.problem.domain.extent())
}

/// The front over the square root of time.
fn front_plot(scene: &Scene, recorder: &Recorder<'_>) -> Option<HistoryPlot> {
    let history = recorder.fronts.clone();
    if history.count() < 2 {
        return None;
    }
    let curve = curve(&history, |time| exact_front(scene, time));
    Some(HistoryPlot {
        title: format!("{}: front", scene.title),
        value_label: "front position (m)".to_owned(),
        by_root: true,
        traces: vec![Trace { name: "numerical (SPH)".to_owned(), history, curve }],
    })
}

/// The first probes over time.
fn probe_plot(scene: &Scene, recorder: &Recorder<'_>) -> Option<HistoryPlot> {
    let probes = &scene.problem.probes;
    let histories = recorder.histories.iter().filter(|of| of.count() >= LEAST_READINGS);
    let traces: Vec<Trace> = probes
        .iter()
        .zip(histories)
        .map(|(probe, history)| {
            let exact = scene.exact.as_ref();
            let curve = curve(history, |time| exact.map(|exact| exact.at(probe.at, time)));
            Trace { name: probe.name.clone(), history: history.clone(), curve }
        })
        .collect();
    let which = match traces.len() {
        0 => return None,
        drawn if drawn < probes.len() => format!("the first {drawn} of {} probes", probes.len()),
        _ => "probes".to_owned(),
    };
    Some(HistoryPlot {
        title: format!("{}: {which}", scene.title),
        value_label: value_label(&scene.problem).to_owned(),
        by_root: false,
        traces,
    })
}

/// What `of` gives at the times of a history and between them, closer at early times, when most happens.
fn curve(history: &History, of: impl Fn(f64) -> Option<f64>) -> Vec<(f64, f64)> {
    let end = history.readings().last().map_or(0.0, |reading| reading.time);
    let points = CURVE_POINTS.max(2 * history.readings().count());
    let times = (0..=points).map(|k| end * (k as f64 / points as f64).powi(2));
    times.filter_map(|time| Some((time, of(time)?))).collect()
}

fn value_label(problem: &Problem) -> &'static str {
    if problem.has_curves() { TEMPERATURE } else { VALUE }
}

/// The row along x through the first probe, or through the middle.
fn profile(scene: &Scene, recorder: &Recorder<'_>, exact: Option<&[f64]>) -> Option<Profile> {
    let problem = &scene.problem;
    let position = &problem.particles.position;
    let middle = 0.5 * (problem.domain.min + problem.domain.max);
    let through = problem.probes.first().map_or(middle, |probe| probe.at);
    let mut row = Profile::along_x(position, &recorder.values(), exact, through, problem.spacing)?;
    let (first, last) = (*row.position.first()?, *row.position.last()?);
    row.title = format!("{}, t = {}", scene.title, simulated_time(recorder.time));
    row.values.label = value_label(problem).to_owned();
    row.values.exact_curve = scene.exact.as_ref().map(|solution| {
        let along = |k: usize| first + (last - first) * k as f64 / CURVE_POINTS as f64;
        // The row's own y and z: the nearest row need not go through the point asked for.
        let on_row = |x: f64| DVec3::new(x, row.through.y, row.through.z);
        (0..=CURVE_POINTS).map(along).map(|x| (x, solution.at(on_row(x), recorder.time))).unzip()
    });
    row.enthalpy = problem.melts().then(|| enthalpy(scene, recorder, &row));
    Some(row)
}

/// The enthalpy of a unit volume along a row, and what the exact temperatures give.
fn enthalpy(scene: &Scene, recorder: &Recorder<'_>, row: &Profile) -> Along {
    let problem = &scene.problem;
    let numerical = |&particle: &usize| problem.unit_capacity(particle) * recorder.state[particle];
    let of_exact = |particle: usize, x: f64, temperature: f64| {
        let at = DVec3::new(x, row.through.y, row.through.z);
        let solution: Option<&Solution> = scene.exact.as_ref();
        let liquid = solution.and_then(|of| of.is_liquid(at, recorder.time));
        exact_enthalpy(problem, particle, temperature, liquid)
    };
    // Between particles that of the nearest one's material.
    let nearest = |x: f64| {
        let next = row.position.partition_point(|at| *at < x).min(row.position.len() - 1);
        let before = next.saturating_sub(1);
        let is_before = x - row.position[before] < row.position[next] - x;
        row.particles[if is_before { before } else { next }]
    };
    let exact = row.values.exact.as_ref().map(|exact| {
        let places = row.particles.iter().zip(&row.position).zip(exact);
        places.map(|((particle, x), value)| of_exact(*particle, *x, *value)).collect()
    });
    let exact_curve = row.values.exact_curve.as_ref().map(|(x, values)| {
        let along = x.iter().zip(values).map(|(x, value)| of_exact(nearest(*x), *x, *value));
        (x.clone(), along.collect())
    });
    Along {
        label: "enthalpy (J/m³)".to_owned(),
        value: row.particles.iter().map(numerical).collect(),
        exact,
        exact_curve,
    }
}

/// The enthalpy of a unit volume of a particle's material at a temperature (K), J/m3, where `liquid` says
/// whether it is liquid if that is known. At a sharp melting point alone it has to be: NaN where not.
fn exact_enthalpy(
    problem: &Problem,
    particle: usize,
    temperature: f64,
    liquid: Option<bool>,
) -> f64 {
    let Some(curve) = problem.curve(particle) else {
        return problem.unit_capacity(particle) * temperature;
    };
    let state = curve.enthalpy(temperature);
    let state = match (curve.melting(), liquid) {
        (Some([begins, _]), Some(false)) => state.min(begins),
        (Some([_, ends]), Some(true)) => state.max(ends),
        (Some([begins, ends]), None)
            if begins < ends
                && [begins, ends].map(|of| curve.temperature(of)) == [temperature; 2] =>
        {
            f64::NAN
        }
        _ => state,
    };
    problem.unit_capacity(particle) * state
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;

    #[test]
    fn the_exact_enthalpy_jumps_by_the_latent_heat_at_the_melting_point() {
        let scene = case::load("melting_rod", &[]).expect("a case");
        let problem = &scene.problem;
        let of = |temperature: f64, liquid| exact_enthalpy(problem, 0, temperature, liquid);
        let (capacity, latent) = (19300.0 * 129.0, 19300.0 * 63.7e3);
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} and {b}");
        close(of(350.0, None), capacity * 350.0);
        close(of(450.0, None), capacity * 450.0 + latent);
        close(of(400.0, Some(false)), capacity * 400.0);
        close(of(400.0, Some(true)), capacity * 400.0 + latent);
        assert!(of(400.0, None).is_nan(), "the temperature alone does not tell");
        // A temperature that rounding leaves on the wrong side of the front.
        close(of(400.0f64.next_up(), Some(false)), capacity * 400.0);
        close(of(400.0f64.next_down(), Some(true)), capacity * 400.0 + latent);
    }

    #[test]
    fn curves_reach_from_the_start_to_the_last_reading() {
        let mut history = History::default();
        for time in [0.0, 1.0, 4.0] {
            let reading = crate::report::Reading { time, value: 0.0, exact: None };
            history.push(reading);
        }
        let all = curve(&history, |time| Some(2.0 * time));
        assert_eq!((all[0], all[all.len() - 1]), ((0.0, 0.0), (4.0, 8.0)));
        assert!(all.is_sorted_by(|a, b| a.0 < b.0) && all.iter().all(|p| p.1 == 2.0 * p.0));
        assert!(curve(&history, |_| None).is_empty());
    }
}
