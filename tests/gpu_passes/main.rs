//! Passes on a device against plain Rust. A missing adapter fails these tests; a software one will
//! do.

mod backend;
mod front_lists;
mod limits;
mod list;
mod probe;
mod rate;
mod scan;
mod support;
