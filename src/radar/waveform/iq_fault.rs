//! What may be wrong with a recording of a continuous signal.

use std::fmt;
use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Everything wrong with a recording.
#[derive(Debug)]
pub struct IqFaults(pub Vec<IqFault>);

impl fmt::Display for IqFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.0.iter().enumerate() {
            write!(f, "{}{fault}", if i == 0 { "" } else { "; " })?;
        }
        Ok(())
    }
}

/// One fault of a recording.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum IqFault {
    /// It cannot be read.
    #[error(transparent)]
    Unread(#[from] io::Error),
    /// The samples that metadata belong to cannot be read.
    #[error("its samples, {}: {source}", path.display())]
    NoSamples {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The metadata that samples belong to cannot be read.
    #[error("its metadata, {}: {source}", path.display())]
    NoMetadata {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Metadata that are no JSON.
    #[error("its metadata are no JSON ({message})")]
    Json {
        /// Why.
        message: String,
    },
    /// Metadata longer than any that are read.
    #[error("its metadata are longer than {allowed} bytes")]
    Long {
        /// What is allowed.
        allowed: u64,
    },
    /// A field of the metadata that is not there.
    #[error("{field} is missing; required: {allowed}")]
    Missing {
        /// The field.
        field: &'static str,
        /// What is allowed.
        allowed: String,
    },
    /// A field of the metadata that is not allowed.
    #[error("{field} = {found} is not allowed; allowed: {allowed}")]
    Field {
        /// The field.
        field: &'static str,
        /// What it holds.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// A length that is no number of samples.
    #[error(
        "{bytes} bytes of samples are no whole number of {datatype} samples; allowed: another datatype, or the file cut by {more} \
         bytes"
    )]
    Ragged {
        /// Bytes of samples.
        bytes: u64,
        /// Their type.
        datatype: &'static str,
        /// What is left over.
        more: u64,
    },
    /// No samples.
    #[error("it has no samples")]
    Empty,
    /// Nothing but zeros, as far as was looked.
    #[error("no sample of {looked} that were looked at differs from zero")]
    Silent {
        /// How many.
        looked: u64,
    },
    /// A sample that is no number.
    #[error("sample {number} (from 0) is no number, or too large; allowed: up to 1e150")]
    NotFinite {
        /// Which.
        number: u64,
    },
    /// Another file than it was.
    #[error("it has changed since the run began; allowed: a file that nobody writes to, such as a copy")]
    Changed,
}
