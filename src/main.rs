//! The `diffusph` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    diffusph::cli::main()
}
