//! Growth over the step, and where the bounds lie, as pictures.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::StepScan;
use crate::report::canvas::{self, Area, Drawn, FINE, Failure, GRID, INK, font, line};

const WIDTH: i32 = 900;
const PANEL: i32 = 300;
const HEADER: i32 = 44;
const ROW: i32 = 20;
const NAME_WIDTH: i32 = 250;

const MEASURED: RGBColor = RGBColor(0x1f, 0x6f, 0xb4);
const EXPECTED: RGBColor = RGBColor(0xd9, 0x5f, 0x02);
const SAFE: RGBColor = RGBColor(0x1a, 0x93, 0x6f);
const REPORTS: RGBColor = RGBColor(0x8a, 0x5f, 0xb0);

/// The largest growth that is shown.
const TOP: f64 = 5.2;

type Chart<'c, 'b> = ChartContext<'c, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Growth over the step in dx^2 / D, one panel a scan: what runs did, what the largest eigenvalue says, and
/// the bounds.
pub(super) fn growth(scans: &[&StepScan]) -> Result<String, Failure> {
    let size = (WIDTH, HEADER + PANEL * scans.len() as i32);
    canvas::svg(size, |root| {
        let (header, panels) = root.split_vertically(HEADER * FINE);
        legend(&header)?;
        for (scan, area) in scans.iter().zip(panels.split_evenly((scans.len(), 1))) {
            growth_panel(&area, scan)?;
        }
        Ok(())
    })
}

fn legend(area: &Area<'_>) -> Drawn {
    let y = 24 * FINE;
    let style = font(13.0).pos(Pos::new(HPos::Left, VPos::Center));
    area.draw(&Circle::new((70 * FINE, y), 4 * FINE, MEASURED.filled()))?;
    area.draw_text("measured in runs", &style, (82 * FINE, y))?;
    let lines = [
        (220, EXPECTED, "|1 − dt λmax|"),
        (370, SAFE, "safe bound"),
        (500, REPORTS, "(117) and (116)"),
        (660, INK, "measured limit"),
    ];
    for (x, color, words) in lines {
        area.draw(&PathElement::new([(x * FINE, y), ((x + 26) * FINE, y)], line(color, 2.0)))?;
        area.draw_text(words, &style, ((x + 34) * FINE, y))?;
    }
    Ok(())
}

fn growth_panel(area: &Area<'_>, scan: &StepScan) -> Drawn {
    let in_units = |step: f64| step / scan.unit_s;
    let last = scan.points.last().map_or(1.0, |point| in_units(point.step_s));
    let right = 1.04 * last.max(in_units(scan.cfl_s));
    let mut builder = ChartBuilder::on(area);
    builder
        .caption(&scan.scene, font(14.0))
        .margin_left(14 * FINE)
        .margin_right(24 * FINE)
        .margin_bottom(4 * FINE)
        .set_label_area_size(LabelAreaPosition::Left, 56 * FINE)
        .set_label_area_size(LabelAreaPosition::Bottom, 44 * FINE);
    let mut chart = builder.build_cartesian_2d(0.0..right, 0.0..TOP)?;
    chart
        .configure_mesh()
        .max_light_lines(0)
        .bold_line_style(line(GRID, 1.0))
        .axis_style(line(INK, 1.0))
        .label_style(font(12.0))
        .axis_desc_style(font(13.0))
        .x_labels(9)
        .y_labels(6)
        .set_all_tick_mark_size(4 * FINE)
        .x_desc("step over dx²/D")
        .y_desc("growth a step")
        .draw()?;
    chart.draw_series(LineSeries::new([(0.0, 1.0), (right, 1.0)], line(INK, 0.75)))?;
    let limit = scan.limit_s.map_or(f64::INFINITY, in_units);
    let expected = (0..=300).map(|k| {
        let step = last * f64::from(k) / 300.0;
        (step, (1.0 - 2.0 * step / limit).abs())
    });
    chart.draw_series(LineSeries::new(expected, line(EXPECTED, 1.75)))?;
    let bounds = [
        (scan.measured_limit_s, INK, "limit", 0.9),
        (scan.safe_s, SAFE, "safe", 0.77),
        (Some(scan.cfl_third_s), REPORTS, "(117)", 0.64),
        (Some(scan.cfl_s), REPORTS, "(116)", 0.64),
    ];
    for (bound, color, name, height) in bounds {
        if let Some(bound) = bound {
            mark(&mut chart, in_units(bound), color, name, height * TOP)?;
        }
    }
    let points = scan.points.iter().filter(|point| point.growth.is_finite());
    let points = points.map(|point| (in_units(point.step_s), point.growth.min(TOP)));
    chart.draw_series(points.map(|p| Circle::new(p, 4 * FINE, MEASURED.filled())))?;
    Ok(())
}

/// A named line at a step.
fn mark(chart: &mut Chart<'_, '_>, at: f64, color: RGBColor, name: &str, height: f64) -> Drawn {
    chart.draw_series(LineSeries::new([(at, 0.0), (at, height)], line(color, 1.5)))?;
    let style = font(12.0).color(&color).pos(Pos::new(HPos::Center, VPos::Bottom));
    chart.draw_series([Text::new(name.to_owned(), (at, height + 0.04), style)])?;
    Ok(())
}

/// The bounds of every scan over its measured limit, on a logarithmic axis.
pub(super) fn bounds(scans: &[&StepScan]) -> Result<String, Failure> {
    let rows: Vec<&&StepScan> =
        scans.iter().filter(|scan| scan.measured_limit_s.is_some()).collect();
    let bottom = 52;
    let height = HEADER + ROW * rows.len() as i32 + bottom;
    let [low, high] = [0.01_f64, 10.0].map(f64::log10);
    let place = |ratio: f64| {
        let share = (ratio.log10().clamp(low, high) - low) / (high - low);
        NAME_WIDTH + (share * f64::from(WIDTH - NAME_WIDTH - 30)) as i32
    };
    canvas::svg((WIDTH, height), |root| {
        let y_end = HEADER + ROW * rows.len() as i32;
        let label = |x: i32, y: i32, words: &str, side: HPos| {
            let style = font(12.5).pos(Pos::new(side, VPos::Center));
            root.draw_text(words, &style, (x * FINE, y * FINE))
        };
        for tick in [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0] {
            let x = place(tick);
            let (color, width) = if tick == 1.0 { (INK, 1.25) } else { (GRID, 1.0) };
            let ends = [(x * FINE, (HEADER - 4) * FINE), (x * FINE, y_end * FINE)];
            root.draw(&PathElement::new(ends, line(color, width)))?;
            label(x, y_end + 14, &tick.to_string(), HPos::Center)?;
        }
        label(place(0.3), y_end + 36, "step over the measured limit", HPos::Center)?;
        let kinds = [("(117)", REPORTS), ("safe bound", SAFE), ("(116)", REPORTS)];
        for (number, (name, color)) in kinds.into_iter().enumerate() {
            let x = NAME_WIDTH + 20 + 150 * number as i32;
            marker(root, (x, 20), number, color)?;
            label(x + 14, 20, name, HPos::Left)?;
        }
        for (row, scan) in rows.iter().enumerate() {
            let y = HEADER + ROW * row as i32 + ROW / 2;
            label(NAME_WIDTH - 12, y, &scan.scene, HPos::Right)?;
            let Some(limit) = scan.measured_limit_s else { continue };
            let all = [Some(scan.cfl_third_s), scan.safe_s, Some(scan.cfl_s)];
            for (number, bound) in all.into_iter().enumerate() {
                if let Some(bound) = bound {
                    marker(root, (place(bound / limit), y), number, kinds[number].1)?;
                }
            }
        }
        Ok(())
    })
}

/// A shape for each bound, so that colour does not carry it alone.
fn marker(root: &Area<'_>, (x, y): (i32, i32), number: usize, color: RGBColor) -> Drawn {
    let (x, y, size) = (x * FINE, y * FINE, 5 * FINE);
    match number {
        0 => root.draw(&TriangleMarker::new((x, y), size, color.filled()))?,
        1 => root.draw(&Circle::new((x, y), size, color.filled()))?,
        _ => {
            let corners = [(x - size, y - size), (x + size, y + size)];
            root.draw(&Rectangle::new(corners, color.filled()))?;
        }
    }
    Ok(())
}
