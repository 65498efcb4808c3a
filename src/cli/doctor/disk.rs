//! How fast a disk takes a recording.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use super::Finding;
use crate::cli::error::CliError;
use crate::files::{Draft, FileFault};
use crate::recording::output::OutputError;

const MB: f64 = 1e6;
const BLOCK: usize = 1 << 20;
/// Written at most.
const BLOCKS: usize = 64;
/// No further block is begun after this time.
const LONGEST: Duration = Duration::from_secs(5);
/// What a recording in real time may take, MB/s: four channels of 2500 samples of 8 bytes at 1 kHz are 80.
const COMFORTABLE_MB_PER_S: f64 = 100.0;

/// Writes a file in a folder, hands it to the disk, and removes it.
pub(super) fn examine(folder: &Path) -> Result<Finding, CliError> {
    let name = folder.join("nereus-doctor");
    let (draft, file) = Draft::file(&name).map_err(OutputError::File)?;
    let measured = write(file);
    let at = draft.path().to_owned();
    draft.abandon();
    let (bytes, elapsed_s) = measured.map_err(FileFault::io(&at, "writing")).map_err(OutputError::File)?;
    let rate = bytes as f64 / MB / elapsed_s.max(1e-9);
    let free = free_bytes(folder).map(|free| format!(", {:.1} GB free", free / 1e9)).unwrap_or_default();
    let found = format!("{rate:.0} MB/s written and synchronised in {}{free}", folder.display());
    let remedy =
        "record to a faster disk, or fewer channels and samples; `nereus check` says what a run writes";
    Ok(Finding::new("disk", rate >= COMFORTABLE_MB_PER_S, found, remedy).of(rate, "MB/s"))
}

/// Bytes that were written, and how long they took, s.
fn write(mut file: File) -> io::Result<(usize, f64)> {
    // No disk makes less of it.
    let block: Vec<u8> = (0..BLOCK as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let begun = Instant::now();
    let mut bytes = 0;
    for _ in 0..BLOCKS {
        file.write_all(&block)?;
        bytes += block.len();
        if begun.elapsed() >= LONGEST {
            break;
        }
    }
    file.sync_all()?;
    Ok((bytes, begun.elapsed().as_secs_f64()))
}

#[cfg(unix)]
fn free_bytes(folder: &Path) -> Option<f64> {
    let found = nix::sys::statvfs::statvfs(folder).ok()?;
    Some(found.blocks_available() as f64 * found.fragment_size() as f64)
}

#[cfg(not(unix))]
fn free_bytes(_: &Path) -> Option<f64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_stays_in_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let finding = examine(folder.path()).unwrap();
        assert!(finding.value.unwrap() > 0.0 && finding.unit == Some("MB/s"), "{finding:?}");
        assert!(finding.found.contains(" GB free") || cfg!(not(unix)), "{finding:?}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        let missing = examine(&folder.path().join("missing")).unwrap_err();
        assert_eq!(missing.exit_code(), 2, "{missing}");
    }
}
