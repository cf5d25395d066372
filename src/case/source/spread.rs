//! What comes from a point, spread over the particles around it.

use std::sync::{Arc, Mutex};

use glam::DVec3;

use crate::model::{Domain, Kernel, ScalarField};

/// Where a point source is.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Place {
    /// At rest, m.
    At(DVec3),
    /// On its way along straight lines between points (m) from `start` (s) on, at `speed` (m/s); nowhere
    /// before and after.
    Along { points: Vec<DVec3>, speed: f64, start: f64 },
}

impl Place {
    /// Where it is at time `t` (s), if anywhere.
    fn now(&self, t: f64) -> Option<DVec3> {
        let (points, speed, start) = match self {
            Self::At(at) => return Some(*at),
            Self::Along { points, speed, start } => (points, *speed, *start),
        };
        let mut left = speed * (t - start);
        if left < 0.0 {
            return None;
        }
        for ends in points.windows(2) {
            let way = ends[1] - ends[0];
            let length = way.length();
            if left <= length {
                return Some(ends[0] + way * (left / length));
            }
            left -= length;
        }
        None
    }

    /// Between which times (s) it is anywhere, if not always.
    pub(super) fn duration(&self) -> Option<[f64; 2]> {
        let Self::Along { points, speed, start } = self else {
            return None;
        };
        let length: f64 = points.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
        Some([*start, start + length / speed])
    }

    /// The distance of `x` (m) from everywhere it comes.
    pub(super) fn distance(&self, domain: &Domain, x: DVec3) -> f64 {
        let to = |image: DVec3| match self {
            Self::At(at) => image.distance(*at),
            Self::Along { points, .. } => {
                let parts = points.windows(2).map(|ends| {
                    let way = ends[1] - ends[0];
                    let share = (image - ends[0]).dot(way) / way.length_squared();
                    image.distance(ends[0] + share.clamp(0.0, 1.0) * way)
                });
                parts.fold(f64::INFINITY, f64::min)
            }
        };
        images(domain, x).map(to).fold(f64::INFINITY, f64::min)
    }

    /// The length of its way (m) on which none of `members` is within `reach` (m).
    pub(super) fn way_without(
        &self,
        domain: &Domain,
        members: impl Iterator<Item = DVec3>,
        reach: f64,
    ) -> f64 {
        let Self::Along { points, .. } = self else {
            return 0.0;
        };
        let mut covered = Vec::new();
        for x in members {
            for image in images(domain, x) {
                let mut before = 0.0;
                for ends in points.windows(2) {
                    let way = ends[1] - ends[0];
                    let length = way.length();
                    let along = (image - ends[0]).dot(way) / length;
                    let aside = image.distance_squared(ends[0]) - along * along;
                    let half = (reach * reach - aside).max(0.0).sqrt();
                    let [from, to] = [along - half, along + half].map(|s| s.clamp(0.0, length));
                    if from < to {
                        covered.push([before + from, before + to]);
                    }
                    before += length;
                }
            }
        }
        covered.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let whole: f64 = points.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
        let (mut reached, mut without) = (0.0_f64, 0.0);
        for [from, to] in covered {
            without += (from - reached).max(0.0);
            reached = reached.max(to);
        }
        without + (whole - reached).max(0.0)
    }
}

/// `x` (m) and its images across the periodic axes.
fn images(domain: &Domain, x: DVec3) -> impl Iterator<Item = DVec3> {
    let extent = domain.extent();
    let steps = domain.periodic.map(|periodic| if periodic { -1..=1 } else { 0..=0 });
    let [along_x, along_y, along_z] = steps;
    along_x.flat_map(move |i| {
        let along_z = along_z.clone();
        along_y.clone().flat_map(move |j| {
            let step = move |k: i32| DVec3::new(f64::from(i), f64::from(j), f64::from(k));
            along_z.clone().map(move |k| x + step(k) * extent)
        })
    })
}

/// A power in a place, shared by the particles around it in proportion to the kernel and divided by the
/// sum of these shares: what enters is the power to the last bits, beside walls too.
pub(super) struct Spread {
    pub(super) place: Place,
    pub(super) power: ScalarField,
    pub(super) kernel: Kernel,
    pub(super) domain: Domain,
    /// Position and volume of the particles that it reaches.
    pub(super) members: Vec<(DVec3, f64)>,
}

impl Spread {
    /// What a particle at a position gets a unit volume, as a function of that and time.
    pub(super) fn into_field(self, text: String) -> ScalarField {
        let depends_on_time =
            self.power.depends_on_time() || matches!(self.place, Place::Along { .. });
        // The sum of the shares is the same for all particles at one time.
        let known: Mutex<Option<(f64, f64)>> = Mutex::new(None);
        let shared = Arc::new(self);
        let at = move |x: DVec3, t: f64| {
            let Some(place) = shared.place.now(t) else {
                return 0.0;
            };
            let mut known = known.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            let sum = match *known {
                Some((time, sum)) if time == t => sum,
                _ => known.insert((t, shared.sum(place))).1,
            };
            match sum > 0.0 {
                true => shared.power.at(place, t) * shared.share(x, place) / sum,
                false => 0.0,
            }
        };
        ScalarField::new(text, at).depending_on(true, depends_on_time)
    }

    fn share(&self, x: DVec3, place: DVec3) -> f64 {
        self.kernel.w(self.domain.nearest_image(x - place).length())
    }

    fn sum(&self, place: DVec3) -> f64 {
        self.members.iter().map(|&(x, volume)| volume * self.share(x, place)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_followed_at_its_speed() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.0, 0.0)];
        let place = Place::Along { points, speed: 0.5, start: 1.0 };
        assert_eq!(place.duration(), Some([1.0, 7.0]));
        assert_eq!(place.now(0.9), None);
        assert_eq!(place.now(2.0), Some(DVec3::new(0.5, 0.0, 0.0)));
        assert_eq!(place.now(5.0), Some(DVec3::new(1.0, 1.0, 0.0)));
        assert_eq!(place.now(7.1), None);
        let domain =
            Domain { min: DVec3::ZERO, max: DVec3::splat(4.0), periodic: [false, true, false] };
        assert_eq!(place.distance(&domain, DVec3::new(3.0, 1.0, 0.0)), 2.0);
        // The nearest image across the periodic axis.
        assert!((place.distance(&domain, DVec3::new(0.5, 3.5, 0.0)) - 0.5).abs() < 1e-12);
        let members = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.5, 0.0)];
        assert!(place.way_without(&domain, members.into_iter(), 0.5) < 1e-12 + 0.5);
        let away = place.way_without(&domain, members[..2].iter().copied(), 0.5);
        assert!((away - 1.5).abs() < 1e-12, "{away}");
    }
}
