//! `nereus new`: scenarios to start from.

use std::io::Write;

use super::args::{NewArgs, Template};
use super::error::CliError;
use crate::config::manual;

/// Prints the template.
pub(super) fn new(args: &NewArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let text = match args.kind {
        Template::Coastal => include_str!("../../configs/coastal.toml").to_owned(),
        Template::Monostatic => include_str!("../../configs/monostatic.toml").to_owned(),
        Template::Spaceborne => include_str!("../../configs/spaceborne.toml").to_owned(),
        Template::Quickstart => include_str!("../../configs/quickstart.toml").to_owned(),
        Template::Calibration => include_str!("../../configs/calibration.toml").to_owned(),
        Template::Sea => include_str!("../../configs/sea.toml").to_owned(),
        Template::Keys => manual::page(),
    };
    out.write_all(text.as_bytes()).map_err(CliError::Output)
}
