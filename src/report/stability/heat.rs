//! Verdicts as a heat map: scenes down, ways across, a verdict with its figure in each cell.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{StabilityReport, Verdict};
use crate::report::canvas::{self, Area, Drawn, FINE, Failure, PAPER, font};

/// The text of cells, which are light in every scheme.
const DARK: RGBColor = RGBColor(0x11, 0x11, 0x11);

const NAME_WIDTH: i32 = 240;
const CELL: (i32, i32) = (104, 26);
const HEADER: i32 = 58;
const LEGEND: i32 = 40;
const LEGEND_LINE: i32 = 22;

/// What colours say.
const MEANINGS: [&str; 4] = [
    "pass: all that was checked holds",
    "degraded: what is promised holds",
    "refused, as documented",
    "FAIL: a promise is broken",
];

/// The heat map of the trials on `machine`, as SVG text.
pub(super) fn svg(report: &StabilityReport, machine: (&str, &str)) -> Result<String, Failure> {
    let (scenes, ways) = report.axes(machine);
    let width = NAME_WIDTH + CELL.0 * ways.len() as i32 + 12;
    let (places, lines) = legend(width);
    let table = HEADER + CELL.1 * scenes.len() as i32;
    let height = table + LEGEND + LEGEND_LINE * (lines - 1);
    canvas::svg((width, height), |root| {
        for (column, way) in ways.iter().enumerate() {
            let x = NAME_WIDTH + CELL.0 * column as i32 + CELL.0 / 2;
            let lines: Vec<&str> = way.split(", ").collect();
            for (number, line) in lines.iter().enumerate() {
                let y = HEADER - 12 - 17 * (lines.len() - 1 - number) as i32;
                text(root, line, (x, y), HPos::Center, 13.0)?;
            }
        }
        for (row, scene) in scenes.iter().enumerate() {
            let y = HEADER + CELL.1 * row as i32;
            text(root, scene, (NAME_WIDTH - 10, y + CELL.1 / 2), HPos::Right, 13.0)?;
            for (column, way) in ways.iter().enumerate() {
                let x = NAME_WIDTH + CELL.0 * column as i32;
                let trial = report.trial(machine, scene, way);
                let Some(trial) = trial else {
                    text(root, "–", (x + CELL.0 / 2, y + CELL.1 / 2), HPos::Center, 12.0)?;
                    continue;
                };
                cell(root, (x, y), color(trial.verdict), &trial.cell())?;
            }
        }
        for ((verdict, meaning), (x, line)) in Verdict::ALL.into_iter().zip(MEANINGS).zip(places) {
            let y = table + 10 + LEGEND_LINE * line;
            area(root, (x, y + 2), (18, 16), color(verdict))?;
            text(root, meaning, (x + 26, y + 10), HPos::Left, 12.5)?;
        }
        Ok(())
    })
}

/// Where each of [`MEANINGS`] begins and in which line, in a picture of this width; and how many lines.
fn legend(width: i32) -> ([(i32, i32); 4], i32) {
    let (mut x, mut line) = (20, 0);
    let places = MEANINGS.map(|meaning| {
        let taken = 46 + (6.6 * meaning.chars().count() as f64) as i32;
        if x > 20 && x + taken > width {
            (x, line) = (20, line + 1);
        }
        let place = (x, line);
        x += taken;
        place
    });
    (places, line + 1)
}

/// Light enough for dark text, and apart in lightness too.
fn color(verdict: Verdict) -> RGBColor {
    match verdict {
        Verdict::Pass => RGBColor(0xc6, 0xe8, 0xd8),
        Verdict::Degraded => RGBColor(0xfb, 0xd9, 0x8a),
        Verdict::Refused => RGBColor(0xc9, 0xce, 0xd6),
        Verdict::Fail => RGBColor(0xf0, 0x8a, 0x80),
    }
}

fn cell(root: &Area<'_>, (x, y): (i32, i32), fill: RGBColor, words: &str) -> Drawn {
    area(root, (x + 1, y + 1), (CELL.0 - 2, CELL.1 - 2), fill)?;
    let centred = Pos::new(HPos::Center, VPos::Center);
    let style = font(11.5).color(&DARK).pos(centred);
    root.draw_text(words, &style, ((x + CELL.0 / 2) * FINE, (y + CELL.1 / 2) * FINE))?;
    Ok(())
}

fn area(root: &Area<'_>, (x, y): (i32, i32), (w, h): (i32, i32), fill: RGBColor) -> Drawn {
    let corners = [(x * FINE, y * FINE), ((x + w) * FINE, (y + h) * FINE)];
    root.draw(&Rectangle::new(corners, fill.filled()))?;
    root.draw(&Rectangle::new(corners, PAPER.stroke_width(1)))?;
    Ok(())
}

fn text(root: &Area<'_>, words: &str, (x, y): (i32, i32), side: HPos, size: f64) -> Drawn {
    let style = font(size).pos(Pos::new(side, VPos::Center));
    root.draw_text(words, &style, (x * FINE, y * FINE))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_legend_takes_more_lines() {
        let (places, lines) = legend(2000);
        assert_eq!((places.map(|(_, line)| line), lines), ([0; 4], 1));
        let (places, lines) = legend(700);
        assert_eq!((places.map(|(_, line)| line), lines), ([0, 0, 1, 1], 2));
        assert_eq!(places[2].0, places[0].0);
    }
}
