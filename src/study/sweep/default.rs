//! What is swept where the user does not say: a file in `cases/sweeps`, or a rule.

use super::plan::Sweep;
use super::{StudyError, StudyOptions};
use crate::case::Scene;
use crate::model::StepChoice;
use crate::model::integrator::{Method, MethodChoice};

/// The sweeps of shipped cases, by name: what they set and vary is written as `--set` and `--vary`.
const SHIPPED: [(&str, &str); 3] = [
    ("gaussian", include_str!("../../../cases/sweeps/gaussian.json")),
    ("gaussian_small", include_str!("../../../cases/sweeps/gaussian_small.json")),
    ("rod", include_str!("../../../cases/sweeps/rod.json")),
];

/// The default sweeps of the case.
///
/// # Errors
/// A file of ours that cannot be read.
pub(super) fn sweeps(scene: &Scene, options: &StudyOptions<'_>) -> Result<Vec<Sweep>, StudyError> {
    let shipped = SHIPPED.iter().find(|(name, _)| *name == options.case);
    match shipped {
        Some((name, text)) => serde_json::from_str(text)
            .map_err(|error| StudyError::Sweep { name, why: error.to_string() }),
        None => by_rule(scene),
    }
}

/// Spacings by factors of two around the case's own with both corrections, and at its own spacing the
/// methods beside the case's. Steps of explicit Euler go with the square of the spacing, so that its
/// error falls as that of the particles does.
fn by_rule(scene: &Scene) -> Result<Vec<Sweep>, StudyError> {
    let problem = &scene.problem;
    let spacing = problem.spacing;
    let spacings = [4.0, 2.0, 1.0, 0.5].map(|factor| format!("{}", factor * spacing));
    let own = match problem.time.method {
        MethodChoice::Given(method) => method.name(),
        MethodChoice::Automatic => MethodChoice::AUTO,
    };
    let is_euler = problem.time.method == MethodChoice::Given(Method::Euler);
    let vary = |text: String| super::Vary::parse(&text);
    let mut refined = Sweep { vary: vec![vary(format!("method={own}"))?], ..Sweep::default() };
    if let (StepChoice::Given(step), true) = (problem.time.step, is_euler) {
        refined.set.push(format!("time.step={:?}*spacing^2", step / (spacing * spacing)));
    }
    refined.vary.push(vary(format!("spacing={}", spacings.join(",")))?);
    refined.vary.push(vary("correction=none,moment".to_owned())?);
    let others: Vec<&str> = ["rkl2", "tr_bdf2"].into_iter().filter(|name| *name != own).collect();
    let mut by_method = Sweep::default();
    by_method.vary.push(vary(format!("method={}", others.join(",")))?);
    by_method.vary.push(vary(format!("spacing={},{spacing}", 2.0 * spacing))?);
    by_method.vary.push(vary("correction=moment".to_owned())?);
    by_method.vary.push(vary("tolerance=1e-3,1e-4".to_owned())?);
    if problem.time.end == 0.0 || problem.time.method == MethodChoice::Given(Method::Steady) {
        return Ok(vec![refined]);
    }
    Ok(vec![refined, by_method])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;

    #[test]
    fn every_shipped_case_has_a_sweep_that_loads() {
        for (name, _) in case::shipped() {
            // What is large is not built here.
            if ["constant", "affine", "gaussian"].contains(&name.as_str()) {
                continue;
            }
            let scene = case::load(&name, &[]).expect("a case");
            let options = StudyOptions::new(&name);
            let sweeps = sweeps(&scene, &options).expect("sweeps");
            let all = super::super::plan::candidates(&sweeps, &options);
            let loads = all.iter().filter(|candidate| {
                let coarse = !candidate.settings.iter().any(|of| {
                    of.name == "spacing"
                        && of.value.parse().is_ok_and(|x: f64| x < scene.problem.spacing)
                });
                coarse && candidate.load(&name).is_ok()
            });
            assert!(loads.count() >= 3, "{name}: {} settings", all.len());
        }
    }

    #[test]
    fn laws_known_elsewhere_come_with_the_sweep_of_their_case_alone() {
        let laws = |name: &str| -> Vec<String> {
            let scene = case::load(name, &[]).expect("a case");
            let sweeps = sweeps(&scene, &StudyOptions::new(name)).expect("sweeps");
            let laws = sweeps.into_iter().flat_map(|sweep| sweep.reference_laws);
            laws.map(|law| format!("{} {}", law.factor, law.order)).collect()
        };
        assert_eq!(laws("rod"), ["0.0715 0.75"]);
        for other in ["square", "gaussian_small"] {
            assert!(laws(other).is_empty(), "{other}");
        }
    }

    #[test]
    fn files_name_shipped_cases_and_are_read() {
        for (name, text) in SHIPPED {
            assert!(case::shipped_text(name).is_ok(), "{name}");
            let sweeps: Vec<Sweep> = serde_json::from_str(text).expect(name);
            assert!(sweeps.len() > 1 && sweeps.iter().all(|sweep| !sweep.vary.is_empty()));
            let broken = text.replacen("spacing=", "spacng=", 1);
            assert!(serde_json::from_str::<Vec<Sweep>>(&broken).is_err(), "a slip is noticed");
        }
    }
}
