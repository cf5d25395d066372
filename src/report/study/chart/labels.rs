//! Labels beside marks: near theirs, over nothing else.

use crate::report::canvas::width_of;

/// Half the extent of a mark.
const MARK: f64 = 5.5;

/// A rectangle in shown units; y grows downward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

impl Frame {
    fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    fn contains(&self, other: &Self) -> bool {
        other.left >= self.left
            && other.right <= self.right
            && other.top >= self.top
            && other.bottom <= self.bottom
    }

    /// Whether the line between two points goes through it, as far as points along it tell.
    fn is_crossed(&self, [a, b]: &[(f64, f64); 2]) -> bool {
        let steps = ((b.0 - a.0).hypot(b.1 - a.1) / 2.0).ceil().max(1.0) as u32;
        (0..=steps).any(|k| {
            let part = f64::from(k) / f64::from(steps);
            let (x, y) = (a.0 + part * (b.0 - a.0), a.1 + part * (b.1 - a.1));
            self.overlaps(&Self::around((x, y), 1.0))
        })
    }

    fn around((x, y): (f64, f64), half: f64) -> Self {
        Self { left: x - half, right: x + half, top: y - half, bottom: y + half }
    }
}

/// Each text with the middle of its left edge, where it lies within `frame`, on no mark, on no
/// stroke between two points and on no other text; the first ones first. A text for which there is
/// no such room may lie on strokes, and is left out where that does not help.
pub(super) fn place<'a>(
    frame: &Frame,
    marks: &[(f64, f64)],
    strokes: &[[(f64, f64); 2]],
    texts: &[(&'a str, bool)],
    size: f64,
) -> Vec<(&'a str, (f64, f64))> {
    let mut order: Vec<usize> = (0..texts.len()).filter(|&k| !texts[k].0.is_empty()).collect();
    order.sort_by_key(|&k| !texts[k].1);
    let mut taken: Vec<Frame> = marks.iter().map(|&at| Frame::around(at, MARK)).collect();
    let mut placed = Vec::new();
    for k in order {
        let (text, _) = texts[k];
        let half = 0.5 * size;
        let boxes = places(marks[k], width_of(text, size)).map(|(left, y)| Frame {
            left,
            right: left + width_of(text, size),
            top: y - half,
            bottom: y + half,
        });
        let is_free = |rectangle: &&Frame| {
            let others = taken.iter().enumerate().filter(|(mark, _)| *mark != k);
            frame.contains(rectangle) && !others.into_iter().any(|(_, of)| of.overlaps(rectangle))
        };
        let is_clear = |rectangle: &&Frame| {
            is_free(rectangle) && !strokes.iter().any(|stroke| rectangle.is_crossed(stroke))
        };
        let found = boxes.iter().find(is_clear).or_else(|| boxes.iter().find(is_free));
        if let Some(&found) = found {
            taken.push(found);
            placed.push((text, (found.left, 0.5 * (found.top + found.bottom))));
        }
    }
    placed
}

/// Where a text of a width may stand beside a mark, the best first: left edge and middle.
fn places((x, y): (f64, f64), width: f64) -> [(f64, f64); 16] {
    let gap = MARK + 2.0;
    let (after, before, over) = (x + gap, x - gap - width, x - 0.5 * width);
    let near = [
        (after, y),
        (before, y),
        (over, y - 13.0),
        (over, y + 13.0),
        (after - 3.0, y - 10.0),
        (after - 3.0, y + 10.0),
        (before + 3.0, y - 10.0),
        (before + 3.0, y + 10.0),
    ];
    let far = [
        (over, y - 24.0),
        (over, y + 24.0),
        (after + 4.0, y - 20.0),
        (after + 4.0, y + 20.0),
        (before - 4.0, y - 20.0),
        (before - 4.0, y + 20.0),
        (after + 12.0, y),
        (before - 12.0, y),
    ];
    std::array::from_fn(|k| if k < 8 { near[k] } else { far[k - 8] })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame { left: 0.0, right: 400.0, top: 0.0, bottom: 300.0 };

    #[test]
    fn labels_are_near_their_marks_and_over_nothing_else() {
        let marks: Vec<(f64, f64)> =
            (0..12).map(|k| (100.0 + 14.0 * f64::from(k), 150.0 + f64::from(k % 3))).collect();
        let texts: Vec<String> = (0..12).map(|k| k.to_string()).collect();
        let texts: Vec<(&str, bool)> = texts.iter().map(|text| (&**text, text == "11")).collect();
        let placed = place(&FRAME, &marks, &[], &texts, 11.0);
        assert_eq!(placed.len(), 12, "there is room for all");
        assert_eq!(placed[0].0, "11", "the first ones first");
        let boxes: Vec<Frame> = placed
            .iter()
            .map(|&(text, (x, y))| Frame {
                left: x,
                right: x + width_of(text, 11.0),
                top: y - 5.5,
                bottom: y + 5.5,
            })
            .collect();
        for (k, a) in boxes.iter().enumerate() {
            assert!(FRAME.contains(a));
            assert!(boxes[..k].iter().all(|b| !a.overlaps(b)), "{k}");
        }
    }

    #[test]
    fn a_label_keeps_off_strokes_where_it_can() {
        let (marks, texts) = ([(200.0, 150.0)], [("7", true)]);
        let at = |strokes: &[[(f64, f64); 2]]| place(&FRAME, &marks, strokes, &texts, 11.0)[0].1;
        assert_eq!(at(&[]).1, 150.0);
        assert_ne!(at(&[[(100.0, 150.0), (300.0, 150.0)]]).1, 150.0);
        let everywhere: Vec<[(f64, f64); 2]> =
            (0..60).map(|k| 5.0 * f64::from(k)).map(|y| [(0.0, y), (400.0, y)]).collect();
        assert_eq!(at(&everywhere).1, 150.0, "it is better on strokes than left out");
    }

    #[test]
    fn a_label_without_room_is_left_out() {
        let marks = [(200.0, 150.0); 40];
        let texts = [("a rather long label", false); 40];
        let placed = place(&FRAME, &marks, &[], &texts, 11.0);
        assert!((1..20).contains(&placed.len()), "{}", placed.len());
        assert!(place(&FRAME, &[(200.0, 150.0)], &[], &[("", true)], 11.0).is_empty());
    }
}
