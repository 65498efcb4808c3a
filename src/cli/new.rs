//! `nereus new`: scenarios to start from.

use clap::Args;
use clap::ValueEnum;
use std::io::Write;

use super::error::CliError;
use super::report::Report;
use crate::config::manual;

/// `nereus new`
#[derive(Debug, Args)]
pub struct NewArgs {
    /// What to print
    #[arg(value_enum, default_value_t = Template::Coastal)]
    pub kind: Template,
    /// List what there is to print, a line each
    #[arg(long, conflicts_with = "kind")]
    pub list: bool,
}

/// What `nereus new` prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// Coastal transmitter, airborne receiver; stands alone
    Coastal,
    /// One aircraft, alternating polarisation, ADC; stands alone
    Monostatic,
    /// From orbit, several pulses in the air; stands alone
    Spaceborne,
    /// A small patch of sea under one aircraft, with swell and a slick; stands alone
    Sea,
    /// The whole thing: recorded flight, sea, ship, targets; needs configs/tracks and hulls as in the
    /// repository
    Quickstart,
    /// Recorded flight and a field of point targets; needs configs/tracks beside it
    Calibration,
    /// Every key with unit, default and range (Markdown)
    Keys,
}

/// Prints the template.
pub(super) fn new(args: &NewArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let text = match args.kind {
        _ if args.list => list(),
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

/// The kinds, each with what it is.
fn list() -> String {
    let mut report = Report::default();
    for kind in Template::value_variants().iter().filter_map(Template::to_possible_value) {
        let help = kind.get_help().map(ToString::to_string).unwrap_or_default();
        report.row(kind.get_name(), help);
    }
    report.text()
}
