//! A recording of either kind that is open for reading.

#[cfg(feature = "hdf5")]
use std::io::Read;
use std::ops::Range;
use std::path::Path;

use super::columns::{Column, Rows};
use super::fault::{READING, RecordingError};
#[cfg(feature = "hdf5")]
use super::hdf5::{self, fault::Fault};
use super::header::Header;
use super::plain;
use crate::files::FileFault;
#[cfg(feature = "hdf5")]
use crate::inputs;

/// Where rows come from.
pub(super) enum Source {
    #[cfg(feature = "hdf5")]
    Hdf5(hdf5::reader::Reader),
    Plain(plain::reader::Reader),
}

/// Pulses of a recording; `None` where it cannot be read, or is of another kind.
pub(crate) fn pulses_in(path: &Path) -> Option<usize> {
    Source::open(path).ok().map(|recorded| recorded.pulses())
}

impl Source {
    pub(super) fn open(path: &Path) -> Result<Self, RecordingError> {
        if path.is_dir() {
            return plain::reader::Reader::open(path).map(Self::Plain);
        }
        let data = std::fs::metadata(path).map_err(FileFault::io(path, READING))?;
        if !data.is_file() {
            let detail = "is no regular file; recordings are files or folders".to_owned();
            return Err(RecordingError::Foreign { path: path.to_owned(), detail });
        }
        #[cfg(feature = "hdf5")]
        {
            let mut signature = [0; 8];
            let read = inputs::open(path).and_then(|mut file| file.read_exact(&mut signature));
            if read.is_ok() && signature != *b"\x89HDF\r\n\x1a\n" {
                let detail = "is no HDF5 file; recordings are HDF5 files or folders".to_owned();
                return Err(RecordingError::Foreign { path: path.to_owned(), detail });
            }
            let recorded = hdf5::reader::Reader::open(path).map_err(Fault::at(path, READING))?;
            Ok(Self::Hdf5(recorded))
        }
        #[cfg(not(feature = "hdf5"))]
        Err(RecordingError::NoHdf5 { path: path.to_owned() })
    }

    pub(super) fn header(&self) -> &Header {
        match self {
            #[cfg(feature = "hdf5")]
            Self::Hdf5(recorded) => &recorded.header,
            Self::Plain(plain) => &plain.header,
        }
    }

    pub(super) fn pulses(&self) -> usize {
        match self {
            #[cfg(feature = "hdf5")]
            Self::Hdf5(recorded) => recorded.pulses,
            Self::Plain(plain) => plain.pulses,
        }
    }

    pub(super) fn has(&self, column: &Column) -> bool {
        match self {
            #[cfg(feature = "hdf5")]
            Self::Hdf5(recorded) => recorded.has(column),
            Self::Plain(plain) => plain.has(column),
        }
    }

    /// Whole rows of a column, and bytes beyond them.
    pub(super) fn length(&self, column: &Column) -> Result<(u64, u64), RecordingError> {
        match self {
            #[cfg(feature = "hdf5")]
            Self::Hdf5(recorded) => {
                let rows =
                    recorded.length(column).map_err(Fault::at(column.path.as_ref(), "reading its size"))?;
                Ok((rows, 0))
            }
            Self::Plain(plain) => plain.length(column),
        }
    }

    /// Whether a changed byte is seen.
    pub(super) fn has_checksums(&self) -> bool {
        match self {
            #[cfg(feature = "hdf5")]
            Self::Hdf5(recorded) => recorded.has_checksums(),
            Self::Plain(_) => false,
        }
    }

    /// Whether these rows of a column are there, before anything is allocated for them.
    pub(super) fn holds(
        &self,
        path: &Path,
        column: &Column,
        rows: &Range<usize>,
    ) -> Result<(), RecordingError> {
        match self {
            // Looked at when it was opened.
            #[cfg(feature = "hdf5")]
            Self::Hdf5(_) => Ok(()),
            Self::Plain(plain) => plain.holds(path, column, rows),
        }
    }

    pub(super) fn rows(
        &self,
        path: &Path,
        column: &Column,
        rows: Range<usize>,
    ) -> Result<Rows, RecordingError> {
        match self {
            #[cfg(feature = "hdf5")]
            Self::Hdf5(recorded) => {
                let read = recorded.column(column, rows.start, rows.end);
                Ok(read.map_err(Fault::at(path, READING))?)
            }
            Self::Plain(plain) => plain.rows(path, column, rows),
        }
    }
}
