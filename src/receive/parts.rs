//! Recordings of one reception: a sender that begins again gets a file of its own.

use std::path::{Path, PathBuf};

use super::RUNS;
use super::listener::Opener;
use crate::files;
#[cfg(feature = "hdf5")]
use crate::sinks::names_hdf5;
use crate::sinks::plain::PlainSink;
use crate::sinks::sink::Sink;

/// Name of the recording of a further run: `name-2.h5`, `name-3.h5`, ...
fn part(path: &Path, number: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut name = format!("{stem}-{number}");
    if let Some(extension) = path.extension() {
        name = format!("{name}.{}", extension.to_string_lossy());
    }
    path.with_file_name(name)
}

/// Recordings of further runs that an earlier reception left. `flight-20180509.h5` is none, nor what a run
/// has written.
pub fn older(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(files::folder(path)) else { return Vec::new() };
    let stem = format!("{}-", path.file_stem().unwrap_or_default().to_string_lossy());
    let mut found: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| path.with_file_name(entry.file_name()))
        .filter(|candidate| {
            let name = candidate.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let number = name.strip_prefix(&stem).and_then(|number| number.parse().ok());
            let is_part = |number| (2..=RUNS + 1).contains(&number) && part(path, number) == *candidate;
            number.is_some_and(is_part) && is_received(candidate)
        })
        .collect();
    found.sort();
    found
}

fn is_received(path: &Path) -> bool {
    #[cfg(feature = "hdf5")]
    if names_hdf5(path) {
        return crate::recording::hdf5::file::is_received(path);
    }
    crate::recording::plain::is_received(path)
}

/// What makes the recordings of further runs.
pub fn further(path: PathBuf, force: bool) -> Box<dyn Fn(usize) -> Opener + Send + Sync> {
    Box::new(move |number| opener(part(&path, number), force))
}

/// What makes a recording at a path.
pub fn opener(path: PathBuf, force: bool) -> Opener {
    Box::new(move |header| {
        #[cfg(feature = "hdf5")]
        if names_hdf5(&path) {
            let sink = crate::sinks::hdf5::Hdf5Sink::create(&path, None, force, header)?;
            return Ok(Box::new(sink) as Box<dyn Sink>);
        }
        Ok(Box::new(PlainSink::create(&path, force, header)?) as Box<dyn Sink>)
    })
}
