//! What all pictures share: the canvas, its scale, its fonts and its colours.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::html;

/// plotters places everything on whole units; drawn this many times larger than it is shown, lines
/// are smooth.
pub(super) const FINE: i32 = 8;

pub(super) const INK: RGBColor = rgb(html::INK);
pub(super) const GRID: RGBColor = rgb(html::GRID);
pub(super) const PAPER: RGBColor = rgb(html::PAPER);

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Failure = Box<dyn std::error::Error + Send + Sync>;
pub(super) type Drawn = Result<(), Failure>;

const fn rgb([r, g, b]: [u8; 3]) -> RGBColor {
    RGBColor(r, g, b)
}

/// What `draw` puts on a canvas of `size`, as SVG text.
pub(super) fn svg(
    size: (i32, i32),
    draw: impl FnOnce(&Area<'_>) -> Drawn,
) -> Result<String, Failure> {
    let mut text = String::new();
    {
        let canvas = ((size.0 * FINE) as u32, (size.1 * FINE) as u32);
        let root = SVGBackend::with_string(&mut text, canvas).into_drawing_area();
        root.fill(&PAPER)?;
        draw(&root)?;
        root.present()?;
    }
    let [fine, shown] =
        [FINE, 1].map(|scale| format!(r#"width="{}" height="{}""#, size.0 * scale, size.1 * scale));
    Ok(text.replacen(&fine, &shown, 1))
}

/// Font size in units of the canvas; plotters divides sizes by 1.24 on the way to SVG.
pub(super) fn font(size: f64) -> TextStyle<'static> {
    ("sans-serif", size * 1.24 * f64::from(FINE)).into_font().color(&INK)
}

pub(super) fn line(color: RGBColor, width: f64) -> ShapeStyle {
    color.stroke_width((width * f64::from(FINE)) as u32)
}

/// A letter's width over the size of its font, about.
const LETTER: f64 = 0.56;

/// How wide a text is, about.
pub(super) fn width_of(text: &str, size: f64) -> f64 {
    LETTER * size * text.chars().count() as f64
}
