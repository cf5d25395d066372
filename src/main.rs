//! The `diffusph` command.

use std::process::ExitCode;

#[allow(
    unsafe_code,
    reason = "the environment is set before any thread exists, the case that set_var allows"
)]
fn main() -> ExitCode {
    if cfg!(target_os = "linux") && std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Vulkan drivers print an alarming and harmless line where this is not set, as in most
        // containers; any folder will do.
        // SAFETY: no other thread runs yet.
        unsafe { std::env::set_var("XDG_RUNTIME_DIR", std::env::temp_dir()) };
    }
    diffusph::cli::main()
}
