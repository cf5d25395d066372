//! `diffusph cases`: the shipped cases.

use clap::Args;

use super::{CliError, print};
use crate::case;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  diffusph cases\n  diffusph cases gaussian > my_case.json")]
pub(super) struct Arguments {
    /// Print this case instead of the list
    case: Option<String>,
}

pub(super) fn cases(arguments: &Arguments) -> Result<(), CliError> {
    if let Some(name) = &arguments.case {
        return print(case::shipped_text(name)?);
    }
    let cases = case::shipped();
    let width = cases.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let lines = cases.iter().map(|(name, title)| format!("{name:width$}  {title}\n"));
    print(lines.collect::<String>())
}
