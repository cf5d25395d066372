//! What a lattice finds past its edges.

/// What lies past one end of an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// Nothing.
    Free,
    /// Ghosts: mirror images whose value is a factor, by layer, times that of their particle, but
    /// for what the wall imposes.
    Mirror(Vec<f64>),
}

/// What lies past the two ends of an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Edge {
    /// The other end.
    Periodic,
    /// What each end says, the lower first.
    Open([End; 2]),
}

/// What is found at a place along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Index of the particle whose value counts.
    pub index: usize,
    /// Factor of that value.
    pub factor: f64,
    /// Whether it is a ghost.
    pub is_ghost: bool,
}

impl Edge {
    /// What is at `place` along an axis of `count` particles; nothing past a free end, nor past the
    /// image of the other end.
    pub fn at(&self, place: isize, count: usize) -> Option<Site> {
        let whole = count as isize;
        let particle = |index: isize| Site { index: index as usize, factor: 1.0, is_ghost: false };
        let ghost = |end: &End, layer: isize, index: isize| match end {
            End::Mirror(factors) if layer < whole => {
                let factor = factors[layer as usize];
                Some(Site { index: index as usize, factor, is_ghost: true })
            }
            End::Free | End::Mirror(_) => None,
        };
        match self {
            _ if (0..whole).contains(&place) => Some(particle(place)),
            Self::Periodic => Some(particle(place.rem_euclid(whole))),
            Self::Open([lower, _]) if place < 0 => ghost(lower, -1 - place, -1 - place),
            Self::Open([_, upper]) => ghost(upper, place - whole, 2 * whole - 1 - place),
        }
    }

    /// Whether nothing lies past the lower or upper end.
    pub fn is_free(&self, upper: bool) -> bool {
        matches!(self, Self::Open(ends) if ends[usize::from(upper)] == End::Free)
    }
}
