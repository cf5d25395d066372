//! A wall that exchanges U (W - C_wall) with an ambient of value W.
//!
//! The line from the particle to its ghost has at the wall the value C_wall and the outward slope
//! U (W - C_wall) / k; without C_wall, the ghost holds
//! ((k - U d) C + 2 U d W) / (k + U d), and the flux is U k / (k + U d) (W - C).

use super::{Conditions, Definition, Inflow, Mirror};

pub(super) static DEFINITION: Definition =
    Definition { name: "convection", mirror: Some(mirror), inflow: Some(inflow) };

fn mirror(at: &Conditions) -> Mirror {
    // k / (k + U d), formed so that neither a huge U nor a tiny k overflows.
    let share = 1.0 / (1.0 + at.coefficient * at.distance / at.conductivity);
    Mirror { scale: 2.0 * share - 1.0, offset: 2.0 * (1.0 - share) }
}

fn inflow(at: &Conditions) -> Inflow {
    let transfer = at.coefficient / (1.0 + at.coefficient * at.distance / at.conductivity);
    Inflow { gain: transfer, loss: transfer }
}
