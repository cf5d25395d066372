//! No wall at all: the support is truncated, as in the report.

use super::Definition;

pub(super) static DEFINITION: Definition = Definition { name: "free", mirror: None, inflow: None };
