//! Drawing a profile as SVG.

use super::axis::Axis;
use super::canvas::{self, Area, Drawn, FINE, Failure};
use super::format::significant;
use super::header::{Header, Sign};
use super::panel::{EXACT, Layer, NUMERICAL, Panel, thin};
use super::profile::{Along, Profile};

const WIDTH: i32 = 900;
/// Height of a panel of values: of the first one and of one below it.
const UPPER: i32 = 360;
const BELOW: i32 = 300;
/// Height of the panel of errors.
const LOWER: i32 = 240;
/// What the labels of the shared axis take from a panel that has them.
const LABELS: i32 = 40;

/// The plot of `profile` as SVG text.
pub(super) fn svg(profile: &Profile) -> Result<String, Failure> {
    let values = &profile.values;
    let error: Option<Vec<f64>> = values
        .exact
        .as_ref()
        .map(|exact| values.value.iter().zip(exact).map(|(v, e)| v - e).collect());
    let with_exact = values.exact.is_some() || values.exact_curve.is_some();
    let exact = with_exact.then_some((Sign::Line(EXACT), "exact"));
    let entries: Vec<_> =
        [(Sign::Dot(NUMERICAL), "numerical (SPH)")].into_iter().chain(exact).collect();
    let header = Header::new(&profile.title, &entries, WIDTH);
    let (top, lower) = (header.height(), if error.is_some() { LOWER } else { 0 });
    let below = match (&profile.enthalpy, &error) {
        (None, _) => 0,
        (Some(_), Some(_)) => BELOW,
        (Some(_), None) => BELOW + LABELS,
    };
    canvas::svg((WIDTH, top + UPPER + below + lower), |root| {
        let (above, panels) = root.split_vertically(top * FINE);
        let (first, rest) = panels.split_vertically(UPPER * FINE);
        header.draw(&above)?;
        let thinned = thin(error.as_ref().unwrap_or(&values.value));
        let is_last = profile.enthalpy.is_none() && error.is_none();
        values_panel(&first, profile, values, &thinned, is_last)?;
        let (second, third) = rest.split_vertically(below * FINE);
        if let Some(enthalpy) = &profile.enthalpy {
            let thinned = thin(&enthalpy.value);
            values_panel(&second, profile, enthalpy, &thinned, error.is_none())?;
        }
        match &error {
            Some(error) => error_panel(&third, profile, error, &thinned),
            None => Ok(()),
        }
    })
}

/// Values along the line; the last panel has the labels of the shared axis.
fn values_panel(
    area: &Area<'_>,
    profile: &Profile,
    values: &Along,
    thinned: &[usize],
    is_last: bool,
) -> Drawn {
    let curve: Vec<(f64, f64)> = match (&values.exact_curve, &values.exact) {
        (Some((x, y)), _) => thin(y).into_iter().map(|i| (x[i], y[i])).collect(),
        (None, Some(y)) => thinned.iter().map(|&i| (profile.position[i], y[i])).collect(),
        (None, None) => Vec::new(),
    };
    let points: Vec<(f64, f64)> =
        thinned.iter().map(|&i| (profile.position[i], values.value[i])).collect();
    let panel = Panel {
        x: Axis::over(profile.position.iter().copied(), 10),
        x_label: is_last.then_some(&profile.axis_label),
        y: Axis::over(curve.iter().chain(&points).map(|p| p.1), 8),
        y_label: &values.label,
        caption: None,
    };
    // The curve comes after the points, which would hide it where they are dense.
    panel.draw(area, &[Layer::Dots(&points, NUMERICAL), Layer::Line(&curve, EXACT, 1.75)])
}

fn error_panel(area: &Area<'_>, profile: &Profile, error: &[f64], thinned: &[usize]) -> Drawn {
    let values = &profile.values;
    let largest = error.iter().fold(0.0, |m: f64, e| super::sum::max_or_nan(m, e.abs()));
    let magnitude =
        values.value.iter().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
    let floor = f64::EPSILON * magnitude;
    let points: Vec<(f64, f64)> =
        thinned.iter().map(|&i| (profile.position[i], error[i])).collect();
    let around_zero = points.iter().map(|p| p.1).chain([-floor, floor]);
    let unit = values.label.find(" (").map_or("", |unit| &values.label[unit..]);
    let panel = Panel {
        x: Axis::over(profile.position.iter().copied(), 10),
        x_label: Some(&profile.axis_label),
        y: Axis::over(around_zero, 6),
        y_label: &format!("error{unit}"),
        caption: Some(format!("numerical − exact, largest {}", significant(largest, 3))),
    };
    panel.draw(area, &[Layer::Dots(&points, NUMERICAL), Layer::Line(&points, NUMERICAL, 1.0)])
}
