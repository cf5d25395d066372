//! A wall that nothing crosses: the ghost holds what its particle holds.

use super::{Definition, Mirror};

pub(super) static DEFINITION: Definition = Definition {
    name: "insulated",
    mirror: Some(|_| Mirror { scale: 1.0, offset: 0.0 }),
    inflow: None,
};
