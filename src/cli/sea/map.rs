//! Maps of the patch of a scenario: the arguments that ask for them, their files.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::error::{CliError, Refused};
use crate::cli::report::Report;
use crate::cli::scenario::{OutputArgs, ScenarioArgs};
use crate::cli::values::one_of;
use crate::plot::patch::{SEA_FIELDS, SeaField};
use crate::recording::output::{FileKind, Output, apart};
use crate::sea::surface::Selection;

/// A map of the patch at a time, and a picture of it.
#[derive(Debug, Args)]
pub struct MapArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Time after pulse 0
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true)]
    pub time_s: f64,
    /// Map to make: every field of the patch (HDF5)
    #[arg(long, value_name = "PATH.h5")]
    pub out: Option<PathBuf>,
    /// Picture to make
    #[arg(long, value_name = "PATH.png")]
    pub png: Option<PathBuf>,
    /// What the picture shows
    #[arg(long, value_parser = one_of(SEA_FIELDS.iter().map(|f| (f.name, f.meaning, f))), default_value = "height")]
    pub field: &'static SeaField,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

impl MapArgs {
    /// What must be evaluated: all that a map holds, else what the picture shows.
    pub(in crate::cli) fn selection(&self, written: Selection) -> Selection {
        match (&self.out, &self.png) {
            (Some(_), _) => written,
            (None, Some(_)) => self.field.selection(),
            (None, None) => Selection::HEIGHT,
        }
    }
}

/// Files that a command makes, under their keys of `--json`.
pub(in crate::cli) fn files<const N: usize>(report: &mut Report, files: [(&str, &Option<PathBuf>); N]) {
    for (key, path) in files {
        report.value(key, path.as_deref().map(Path::to_string_lossy));
    }
}

/// The files that were asked for, each of which may be made, and no two of which are the same.
pub(in crate::cli) fn outputs<const N: usize>(
    asked: [(&Option<PathBuf>, FileKind); N],
    force: bool,
) -> Result<[Option<Output>; N], CliError> {
    let hdf5 = asked.iter().filter(|(_, kind)| *kind == FileKind::Hdf5);
    if let (false, Some(out)) = (cfg!(feature = "hdf5"), hdf5.filter_map(|(path, _)| path.as_ref()).next()) {
        return Err(Refused::NoHdf5Map(out.clone()).into());
    }
    let mut outputs = [const { None }; N];
    for (output, (path, kind)) in outputs.iter_mut().zip(asked) {
        *output = path.as_ref().map(|path| Output::plan(path, kind, force)).transpose()?;
    }
    apart(outputs.iter().flatten())?;
    Ok(outputs)
}
