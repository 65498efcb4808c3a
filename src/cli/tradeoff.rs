//! `nereus tradeoff`: error and speed over the knobs of `[fidelity]`.

use std::io::Write;

use super::args::TradeoffArgs;
use super::error::CliError;

/// Sweeps and prints.
pub(super) fn tradeoff(_args: &TradeoffArgs, _out: &mut dyn Write) -> Result<(), CliError> {
    Ok(())
}
