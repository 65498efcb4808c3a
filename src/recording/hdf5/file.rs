//! HDF5 files of this program: whether they are, and how they are opened.

use std::fs;
use std::io::Read;
use std::path::Path;

use ::hdf5::types::VarLenUnicode;
use ::hdf5::{File, Hyperslab, OpenMode, SliceOrIndex};

use super::fault::Fault;
use crate::files::{Holding, Recognised};
use crate::recording::columns::Column;

/// A file that is finished, growing, or left by a killed run.
pub(super) fn open(path: &Path) -> Result<File, Fault> {
    regular(path)?;
    match File::open(path) {
        Ok(file) => Ok(file),
        // A run that goes on or was killed leaves the open-for-write flag; reading as SWMR accepts it.
        // Nothing else is tried twice.
        Err(plain) if is_marked(&plain) => File::with_options()
            .with_fapl(|fapl| fapl.metadata_read_attempts(READ_ATTEMPTS))
            .open_as(path, OpenMode::ReadSWMR)
            .map_err(|_| plain.into()),
        Err(plain) => Err(plain.into()),
    }
}

/// The attribute `format` of an HDF5 file.
pub(crate) fn format_of(path: &Path) -> Option<Vec<u8>> {
    format_in(&opened(path)?)
}

fn format_in(file: &File) -> Option<Vec<u8>> {
    let format = file.attr("format").ok()?.read_scalar::<VarLenUnicode>().ok()?;
    Some(format.as_bytes().to_owned())
}

/// A file that begins as HDF5 does.
fn opened(path: &Path) -> Option<File> {
    const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
    let mut start = [0; 8];
    regular(path).ok()?;
    fs::File::open(path).and_then(|mut file| file.read_exact(&mut start)).ok()?;
    if start != SIGNATURE {
        return None;
    }
    open(path).ok()
}

/// A file of this program.
fn own(path: &Path) -> Option<File> {
    opened(path).filter(|file| format_in(file).is_some_and(|format| format == b"nereus"))
}

/// Last pulse of the segment before a file.
pub(super) fn after_pulse(file: &File) -> Option<u64> {
    file.attr("after_pulse").ok()?.read_scalar::<u64>().ok()
}

/// Whether a file was written as a segment beyond the first, which a run may begin with.
pub(crate) fn is_later_segment(path: &Path) -> bool {
    own(path).is_some_and(|file| file.attr("segment").is_ok() || after_pulse(&file).is_some())
}

/// Whether a recording was received over the wire.
pub(crate) fn is_received(path: &Path) -> bool {
    let truth = |file: File| file.attr("truth").ok()?.read_scalar::<u8>().ok();
    own(path).and_then(truth) == Some(0)
}

/// Whether a file is a recording of this program, or empty: what a new recording may replace.
pub(crate) fn recognise(path: &Path) -> Recognised {
    let is_empty = fs::symlink_metadata(path).is_ok_and(|data| data.is_file() && data.len() == 0);
    let is_ours = is_empty || format_of(path).is_some_and(|format| format == b"nereus");
    is_ours.then_some(Holding::File).ok_or("HDF5 file whose attribute format is nereus")
}

/// Times that metadata of a growing file is read again before it counts as damaged. The library waits 2^n ns
/// after the n-th attempt: its own 100 would be for ever.
const READ_ATTEMPTS: u32 = 20;

/// Length of a file that is one: reading a pipe or a device may never end.
pub(super) fn regular(path: &Path) -> Result<u64, Fault> {
    let data = fs::metadata(path).map_err(|error| Fault::Text(error.to_string()))?;
    if !data.is_file() {
        return Err(Fault::Text("is no regular file; recordings are files or folders".to_owned()));
    }
    Ok(data.len())
}

/// Whether a file was refused for its writer's mark alone.
fn is_marked(error: &::hdf5::Error) -> bool {
    let is_mark = |text: &str| text.contains("already open for write");
    let frames = error.stack();
    is_mark(&error.to_string())
        || frames.is_some_and(|stack| {
            stack.iter().any(|frame| is_mark(frame.desc()) || is_mark(frame.description()))
        })
}

/// Rows of a column in its dataset.
pub(super) fn slab(column: &Column, from: usize, to: usize) -> Hyperslab {
    let mut slab: Vec<SliceOrIndex> = vec![(from..to).into()];
    slab.extend(column.shape.iter().map(|&n| SliceOrIndex::from(0..n)));
    Hyperslab::from(slab)
}

/// Shape of rows of a column.
pub(super) fn shape(column: &Column, rows: usize) -> Vec<usize> {
    let mut shape = vec![rows];
    shape.extend(&column.shape);
    shape
}
