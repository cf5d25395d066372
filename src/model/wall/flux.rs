//! A wall through which the flux W enters the body: the line from the particle to its ghost, 2 d
//! further out, has the outward slope W / k.

use super::{Definition, Inflow, Mirror};

pub(super) static DEFINITION: Definition = Definition {
    name: "flux",
    mirror: Some(|at| Mirror { scale: 1.0, offset: 2.0 * at.distance / at.conductivity }),
    inflow: Some(|_| Inflow { gain: 1.0, loss: 0.0 }),
};
