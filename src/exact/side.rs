//! What happens at a face of a body.

/// A condition at a face. The solutions are those of dC/dt = D laplacian C, so a conductivity is
/// D and a heat capacity 1: a flux is in units of the value times m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// Held at a value.
    Value(f64),
    /// A flux into the body, D dC/dn = flux with n pointing out of it, value x m/s.
    Flux(f64),
    /// D dC/dn = coefficient (ambient - C), with n pointing out of the body.
    Convection {
        /// Transfer coefficient, m/s, not negative.
        coefficient: f64,
        /// Value of the surroundings.
        ambient: f64,
    },
}

impl Side {
    /// Nothing passes.
    pub const INSULATED: Self = Self::Flux(0.0);

    /// The value it is held at, if it is.
    pub(super) fn held(self) -> Option<f64> {
        if let Self::Value(value) = self { Some(value) } else { None }
    }

    /// The condition on C - `initial`, with `length` (m) as the unit of length.
    pub(super) fn condition(self, initial: f64, diffusivity: f64, length: f64) -> Condition {
        let scale = length / diffusivity;
        match self {
            Self::Value(value) => Condition::Held(value - initial),
            Self::Flux(flux) => Condition::Robin { biot: 0.0, source: flux * scale },
            Self::Convection { coefficient, ambient } => {
                let biot = coefficient * scale;
                Condition::Robin { biot, source: biot * (ambient - initial) }
            }
        }
    }
}

/// A condition on the change c since t = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Condition {
    /// c = this.
    Held(f64),
    /// dc/dn + biot c = source, with n pointing out of the body.
    Robin {
        /// Biot number.
        biot: f64,
        /// Right-hand side.
        source: f64,
    },
}

impl Condition {
    /// The angle between the face and the nearest crest of a wave of wave number `root` that
    /// meets the condition with nothing on its right-hand side.
    pub(super) fn angle(self, root: f64) -> f64 {
        match self {
            Self::Held(_) => std::f64::consts::FRAC_PI_2,
            Self::Robin { biot, .. } => biot.atan2(root),
        }
    }

    /// p, q and s of p c + q dc/dn = s.
    pub(super) fn weights(self) -> (f64, f64, f64) {
        match self {
            Self::Held(value) => (1.0, 0.0, value),
            Self::Robin { biot, source } => (biot, 1.0, source),
        }
    }
}
