//! The `diffusph` command.
fn main() {}
