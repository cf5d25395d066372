//! A wall of given value W: the line from the particle to its ghost passes through W at the wall.

use super::{Definition, Mirror};

pub(super) static DEFINITION: Definition = Definition {
    name: "value",
    mirror: Some(|_| Mirror { scale: -1.0, offset: 2.0 }),
    inflow: None,
};
