//! `nereus import`: scenarios from the files of other programs.

mod antenna;
mod fers;
mod motion;
mod pulse_file;
mod radiated;
mod reading;
mod scene;
mod tree;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use super::error::{CliError, Refused};
use super::report::Report;
use super::scenario::JsonArg;
use super::{counted, escape, say};
use crate::config;
use crate::files::FileFault;
use crate::recording::output::OutputError;

/// Largest document, bytes.
const MOST_BYTES: u64 = 1 << 28;

/// `nereus import`
#[derive(Debug, Args)]
pub struct ImportArgs {
    /// The program whose file it is
    #[command(subcommand)]
    pub from: From,
}

/// Programs whose files are read.
#[derive(Debug, Subcommand)]
pub enum From {
    /// A scene of FERS (fersxml): platforms, waypoints, antennas, waveforms, targets; lists what is left out
    Fers(FersArgs),
}

/// `nereus import fers`
#[derive(Debug, Args)]
pub struct FersArgs {
    /// The scene
    pub scene: PathBuf,
    /// The folder to make: scenario.toml, tracks, waveforms, antenna patterns
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Transmitter to take as that of the radar, by its name; the others become emitters [default: the first]
    #[arg(long, value_name = "NAME")]
    pub radar: Option<String>,
    /// How it is reported
    #[command(flatten)]
    pub format: JsonArg,
}

/// Imports a scene.
pub(super) fn import(args: &ImportArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let From::Fers(args) = &args.from;
    let refused = |faults: Vec<String>| Refused::Import { path: args.scene.clone(), faults };
    let root = read(&args.scene).map_err(refused)?;
    let beside = args.scene.parent().unwrap_or(Path::new("."));
    let found = fers::import(&root, beside, args.radar.as_deref()).map_err(refused)?;
    let scenario = args.folder.join("scenario.toml");
    write(&args.folder, &found)?;
    let mut report = Report::default();
    let names = found.files.iter().map(|(name, _)| args.folder.join(name));
    let files: Vec<PathBuf> = std::iter::once(scenario.clone()).chain(names).collect();
    report.paths("files", files.iter().map(PathBuf::as_path));
    report.value("left_out", &found.left_out);
    report.line(format!("{}: {}", escape::path(&args.folder), counted(files.len() as u64, "file")));
    for what in &found.left_out {
        report.line(format!("left out: {}", escape::name(what)));
    }
    report.say(args.format.json, out)?;
    // What a scenario does not allow, its own reader says best.
    config::load(&scenario, &[])?;
    say("nereus check tells what it is");
    Ok(())
}

fn read(path: &Path) -> Result<tree::Element, Vec<String>> {
    let length = fs::metadata(path).map_err(|error| vec![error.to_string()])?.len();
    if length > MOST_BYTES {
        return Err(vec![format!("{length} bytes; allowed: at most {MOST_BYTES}")]);
    }
    let bytes = fs::read(path).map_err(|error| vec![error.to_string()])?;
    let root = tree::Element::parse(&bytes);
    root.map_err(|fault| vec![format!("line {}: is no XML: {}", fault.line, fault.error)])
}

/// Makes the folder and all files, or neither.
fn write(folder: &Path, found: &fers::Imported) -> Result<(), OutputError> {
    fs::create_dir(folder).map_err(FileFault::io(folder, "making the folder (it must not exist yet)"))?;
    let scenario = ("scenario.toml".to_owned(), found.scenario.clone());
    for (name, text) in found.files.iter().chain([&scenario]) {
        let path = folder.join(name);
        if let Err(error) = fs::write(&path, text) {
            // It holds nothing but what was just written.
            let _ = fs::remove_dir_all(folder);
            return Err(OutputError::File(FileFault::io(&path, "writing")(error)));
        }
    }
    Ok(())
}
