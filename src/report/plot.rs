//! Drawing a profile as SVG.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Axis;
use super::canvas::{self, Area, Drawn, FINE, Failure, GRID, INK, font, line};
use super::format::significant;
use super::profile::Profile;

const WIDTH: i32 = 900;
const HEADER: i32 = 72;
const UPPER: i32 = 360;
const LOWER: i32 = 240;
/// Points beyond this number are thinned out: each bucket keeps its two extremes.
const MOST_POINTS: usize = 2000;

const NUMERICAL: RGBColor = RGBColor(0x1f, 0x6f, 0xb4);
const EXACT: RGBColor = RGBColor(0xd9, 0x5f, 0x02);

type Chart<'c, 'b> = ChartContext<'c, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// The plot of `profile` as SVG text.
pub(super) fn svg(profile: &Profile) -> Result<String, Failure> {
    let error: Option<Vec<f64>> = profile
        .exact
        .as_ref()
        .map(|exact| profile.value.iter().zip(exact).map(|(v, e)| v - e).collect());
    let lower = if error.is_some() { LOWER } else { 0 };
    canvas::svg((WIDTH, HEADER + UPPER + lower), |root| {
        let (header, panels) = root.split_vertically(HEADER * FINE);
        let (top, bottom) = panels.split_vertically(UPPER * FINE);
        draw_header(&header, profile)?;
        let thinned = thin(error.as_ref().unwrap_or(&profile.value));
        values_panel(&top, profile, &thinned)?;
        match &error {
            Some(error) => error_panel(&bottom, profile, error, &thinned),
            None => Ok(()),
        }
    })
}

/// Title, and below it the legend, outside the panels so that it hides nothing.
fn draw_header(area: &Area<'_>, profile: &Profile) -> Drawn {
    let letters = profile.title.chars().count().max(1) as f64;
    let size = (f64::from(WIDTH - 40) / (0.55 * letters)).clamp(8.0, 19.0);
    let centred = Pos::new(HPos::Center, VPos::Center);
    let middle = WIDTH / 2;
    area.draw_text(&profile.title, &font(size).pos(centred), (middle * FINE, 24 * FINE))?;
    let with_exact = profile.exact.is_some() || profile.exact_curve.is_some();
    let left = if with_exact { middle - 125 } else { middle - 55 };
    let (y, style) = (54 * FINE, font(13.0).pos(Pos::new(HPos::Left, VPos::Center)));
    area.draw(&Circle::new(((left + 12) * FINE, y), 4 * FINE, NUMERICAL.filled()))?;
    area.draw_text("numerical (SPH)", &style, ((left + 26) * FINE, y))?;
    if with_exact {
        let ends = [((left + 170) * FINE, y), ((left + 200) * FINE, y)];
        area.draw(&PathElement::new(ends, line(EXACT, 2.0)))?;
        area.draw_text("exact", &style, ((left + 208) * FINE, y))?;
    }
    Ok(())
}

fn values_panel(area: &Area<'_>, profile: &Profile, thinned: &[usize]) -> Drawn {
    let curve: Vec<(f64, f64)> = match (&profile.exact_curve, &profile.exact) {
        (Some((x, y)), _) => thin(y).into_iter().map(|i| (x[i], y[i])).collect(),
        (None, Some(y)) => thinned.iter().map(|&i| (profile.position[i], y[i])).collect(),
        (None, None) => Vec::new(),
    };
    let points: Vec<(f64, f64)> =
        thinned.iter().map(|&i| (profile.position[i], profile.value[i])).collect();
    let axis = Axis::over(curve.iter().chain(&points).map(|p| p.1), 8);
    let panel = Panel {
        x: Axis::over(profile.position.iter().copied(), 10),
        x_label: profile.exact.is_none().then_some(&profile.axis_label),
        y_label: &profile.value_label,
        y: axis,
        caption: None,
    };
    panel.draw(area, &curve, &points, false)
}

fn error_panel(area: &Area<'_>, profile: &Profile, error: &[f64], thinned: &[usize]) -> Drawn {
    let largest = error.iter().fold(0.0, |m: f64, e| super::sum::max_or_nan(m, e.abs()));
    let magnitude =
        profile.value.iter().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
    let floor = f64::EPSILON * magnitude;
    let points: Vec<(f64, f64)> =
        thinned.iter().map(|&i| (profile.position[i], error[i])).collect();
    let around_zero = points.iter().map(|p| p.1).chain([-floor, floor]);
    let panel = Panel {
        x: Axis::over(profile.position.iter().copied(), 10),
        x_label: Some(&profile.axis_label),
        y: Axis::over(around_zero, 6),
        y_label: "error",
        caption: Some(format!("numerical − exact, largest {}", significant(largest, 3))),
    };
    panel.draw(area, &[], &points, true)
}

/// A panel of the plot with its axes.
struct Panel<'a> {
    x: Axis,
    /// `None` where the panel below carries the labels of the shared axis.
    x_label: Option<&'a String>,
    y: Axis,
    y_label: &'a str,
    caption: Option<String>,
}

impl Panel<'_> {
    /// Draws a curve and points over it; `joined` points have a thin line and one at zero.
    fn draw(
        &self,
        area: &Area<'_>,
        curve: &[(f64, f64)],
        points: &[(f64, f64)],
        joined: bool,
    ) -> Drawn {
        let (x, y) = (&self.x, &self.y);
        let mut chart = self.frame(area)?;
        let scaled = |p: &(f64, f64)| (x.scaled(p.0), y.scaled(p.1));
        let drawable = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let radius = if points.len() > 250 { 1.5 } else { 3.0 } * f64::from(FINE);
        let dots = points.iter().filter(|p| drawable(p)).map(scaled);
        chart.draw_series(dots.map(|p| Circle::new(p, radius as i32, NUMERICAL.filled())))?;
        // The curve comes after the points, which would hide it where they are dense.
        let (path, color, width) =
            if joined { (points, NUMERICAL, 1.0) } else { (curve, EXACT, 1.75) };
        // A gap in the data is a gap in the line.
        for run in path.split(|p| !drawable(p)) {
            chart.draw_series(LineSeries::new(run.iter().map(scaled), line(color, width)))?;
        }
        Ok(())
    }

    /// The empty panel: axes, grid, labels and caption.
    fn frame<'b, 'c>(&self, area: &'c Area<'b>) -> Result<Chart<'c, 'b>, Failure> {
        let (x, y) = (&self.x, &self.y);
        let mut builder = ChartBuilder::on(area);
        builder
            .margin_left(10 * FINE)
            .margin_right(28 * FINE)
            .margin_bottom(8 * FINE)
            .margin_top(8 * FINE)
            .set_label_area_size(LabelAreaPosition::Left, 100 * FINE)
            .set_label_area_size(LabelAreaPosition::Bottom, self.bottom() * FINE);
        if let Some(caption) = &self.caption {
            builder.caption(caption, font(13.0));
        }
        let mut chart = builder.build_cartesian_2d(x.range(), y.range())?;
        let (x_text, y_text) = (|v: &f64| x.tick(*v), |v: &f64| y.tick(*v));
        let mut mesh = chart.configure_mesh();
        mesh.max_light_lines(0)
            .bold_line_style(line(GRID, 1.0))
            .axis_style(line(INK, 1.0))
            .label_style(font(12.5))
            .axis_desc_style(font(14.0))
            .x_labels(x.labels)
            .y_labels(y.labels)
            .set_all_tick_mark_size(5 * FINE)
            .y_label_formatter(&y_text)
            .y_desc(y.named(self.y_label));
        match self.x_label {
            Some(label) => mesh.x_label_formatter(&x_text).x_desc(x.named(label)),
            None => mesh.x_label_formatter(&|_| String::new()),
        };
        mesh.draw()?;
        drop(mesh);
        Ok(chart)
    }

    fn bottom(&self) -> i32 {
        if self.x_label.is_some() { 48 } else { 8 }
    }
}

/// Indices that draw `values` well: all, or the least and the greatest of each bucket.
fn thin(values: &[f64]) -> Vec<usize> {
    if values.len() <= MOST_POINTS {
        return (0..values.len()).collect();
    }
    let bucket = values.len().div_ceil(MOST_POINTS / 2);
    let mut kept = Vec::with_capacity(MOST_POINTS);
    for start in (0..values.len()).step_by(bucket) {
        let indices = || start..(start + bucket).min(values.len());
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let mut ends: Vec<usize> = [indices().min_by(by_value), indices().max_by(by_value)]
            .into_iter()
            .flatten()
            .collect();
        ends.sort_unstable();
        ends.dedup();
        kept.extend(ends);
    }
    kept
}
