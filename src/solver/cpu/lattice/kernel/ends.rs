//! What lies past the ends of lines.

use crate::model::lattice::LatticeScene;

/// A place near an end of a line, with the places along it that add to its rate.
#[derive(Debug)]
pub(super) struct NearEnd {
    pub(super) x: usize,
    pub(super) terms: Vec<AlongLine>,
}

/// What is `step` sites along a line: a site `further` along, times a factor.
#[derive(Debug)]
pub(super) struct AlongLine {
    pub(super) step: usize,
    pub(super) further: isize,
    pub(super) factor: f64,
}

impl NearEnd {
    /// The places near both ends of a line.
    pub(super) fn all(scene: &LatticeScene) -> Vec<Self> {
        let (nx, reach) = (scene.counts[0], scene.reach);
        let lower = 0..reach.min(nx);
        let upper = (nx - reach.min(nx)).max(lower.end)..nx;
        let near = |x: usize| {
            let mut terms = Vec::new();
            for step in 1..=reach {
                for there in [x as isize - step as isize, (x + step) as isize] {
                    if let Some(site) = scene.edges[0].at(there, nx) {
                        let further = site.index as isize - x as isize;
                        terms.push(AlongLine { step, further, factor: site.factor });
                    }
                }
            }
            Self { x, terms }
        };
        lower.chain(upper).map(near).collect()
    }
}
