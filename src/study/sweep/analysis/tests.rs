use super::*;
use crate::report::study::Peers;
use crate::report::study::tests::{point, report as sample};

/// A study of points: correction, spacing, time and error.
fn report(points: &[(&str, f64, f64, f64)]) -> StudyReport {
    let numbered = points.iter().enumerate();
    let points = numbered.map(|(k, &(correction, spacing, time, error))| {
        point(k + 1, correction, spacing, time, error)
    });
    let peers = None;
    StudyReport { points: points.collect(), orders: Vec::new(), peers, ..sample() }
}

/// Two series of four spacings: errors of order 2, and errors that stay.
fn two_series() -> StudyReport {
    let mut points = Vec::new();
    for spacing in [0.5, 0.25, 0.125, 0.0625] {
        points.push(("moment", spacing, 1e-3 / spacing, 0.04 * spacing * spacing));
        points.push(("none", spacing, 1e-3 / spacing, 0.02));
    }
    report(&points)
}

#[test]
fn orders_are_those_of_series_in_which_one_thing_varies() {
    let mut study = two_series();
    analyse(&mut study);
    let order = |series: &str| {
        let found = study.orders.iter().find(|order| order.series == series);
        found.unwrap_or_else(|| panic!("no {series}"))
    };
    let (corrected, plain) = (order("corrected"), order("plain"));
    assert_eq!((corrected.varies.as_str(), &corrected.points[..]), ("spacing", &[7, 5, 3, 1][..]));
    assert_eq!((corrected.from, corrected.to), (0.0625, 0.5));
    let slope = |order: &Order| order.all.l2_relative.expect("a slope");
    assert!((slope(corrected) - 2.0).abs() < 1e-12, "{}", slope(corrected));
    assert!(slope(plain).abs() < 1e-12, "{}", slope(plain));
    assert!(corrected.finest.l1.is_some_and(|slope| (slope - 2.0).abs() < 1e-12));
    // One error that does not fit is noticed.
    let result = study.points[6].result.as_mut().expect("it ran");
    result.error.as_mut().expect("an error").l2_relative *= 1.3;
    analyse(&mut study);
    assert!((study.orders[0].all.l2_relative.expect("a slope") - 2.0).abs() > 0.05);
}

#[test]
fn the_order_of_the_steps_is_that_of_their_part() {
    let mut study = report(&[("moment", 0.5, 1.0, 0.01); 4]);
    for (k, point) in study.points.iter_mut().enumerate() {
        let step = 0.1 / f64::from(1 << k);
        point.settings[1].name = "step".to_owned();
        point.settings[1].value = step.to_string();
        let result = point.result.as_mut().expect("it ran");
        result.dt = Some(step);
        let split = result.split.as_mut().expect("a split");
        split.probes[0].parts[1].value = -3.0 * step;
    }
    analyse(&mut study);
    let [order] = &study.orders[..] else { panic!("{:?}", study.orders) };
    assert_eq!(order.varies, "step");
    assert!((order.time_part.expect("a slope") - 1.0).abs() < 1e-12);
    assert!(order.all.l2_relative.expect("a slope").abs() < 1e-12, "the whole error stays");
}

#[test]
fn the_front_has_no_point_that_another_beats() {
    let mut study = report(&[
        ("none", 0.5, 1.0, 0.03),
        ("moment", 0.5, 1.0, 0.01),
        ("moment", 0.25, 3.0, 0.002),
        ("none", 0.25, 4.0, 0.002),
        ("none", 0.125, 0.5, 0.5),
    ]);
    analyse(&mut study);
    let front: Vec<usize> =
        study.measured().filter(|(_, of)| of.pareto).map(|(point, _)| point.number).collect();
    assert_eq!(front, [2, 3, 5]);
}

#[test]
fn the_cheapest_setting_is_recommended_or_none() {
    let mut study = two_series();
    analyse(&mut study);
    let of = |k: usize| &study.recommendations[k];
    assert_eq!(of(0).point, Some(1), "{}", of(0).text);
    assert!(of(0).text.starts_with("For a relative L2 error of 1 %: corrected, dx 0.5 (number 1)"));
    assert_eq!(of(1).point, Some(5), "{}", of(1).text);
    assert_eq!(of(2).point, None);
    assert!(
        of(2).text.contains("no setting of this study reaches it; the least is 0.0156 %"),
        "{}",
        of(2).text
    );
}

#[test]
fn nothing_is_recommended_without_errors() {
    let mut study = StudyReport { recommendations: Vec::new(), ..two_series() };
    study.remarks.clear();
    for point in &mut study.points {
        point.result.as_mut().expect("it ran").error = None;
    }
    analyse(&mut study);
    assert!(study.recommendations.is_empty() && study.orders.is_empty());
    assert!(study.remarks[0].contains("nothing to compare with"), "{:?}", study.remarks);
}

#[test]
fn it_is_said_plainly_where_other_programs_win() {
    let mut study = two_series();
    let peers = |solve: f64, error: f64| {
        let text = format!(
            r#"{{"peers_version": 1, "machine": "m", "points": [{{"tool": "fast", "setup_s": [0],
            "solve_s": [{solve:e}], "l2_relative": {error:e}}}]}}"#
        );
        Some(Peers::parse(&text).expect("peers"))
    };
    study.peers = peers(1e-4, 5e-4);
    analyse(&mut study);
    let said = study.peers_ahead.join("\n");
    assert!(said.contains("1 %: fast WINS") && said.contains("0.1 %: fast WINS"), "{said}");
    assert!(said.contains("No setting here is as fast and as accurate as: fast"), "{said}");
    study.peers = peers(10.0, 5e-4);
    analyse(&mut study);
    let said = study.peers_ahead.join("\n");
    assert!(!said.contains("WINS") && !said.contains("No setting here"), "{said}");
    assert!(said.contains("times as fast as the fastest other program, fast (10 s)"), "{said}");
}
