//! From a recording to a CRSD file: block by block, so that memory stays bounded.

use std::fs::OpenOptions;
use std::ops::Range;
use std::path::Path;

use super::description::Description;
use super::fault::CrsdError;
use super::states::{AntennaRow, BEFORE, BEYOND, PulseRow, recorded_time};
use super::writer::{PulseSamples, Writer};
use crate::recording::columns::{Column, Rows, columns};
use crate::recording::source::Source;
use crate::recording::{RECEIVER_WINDOWS, RecordingError};

/// Samples that are read at a time, bytes.
const BLOCK_BYTES: usize = 8 << 20;
/// Pulses that are read at a time, at most.
const BLOCK_PULSES: usize = 4096;
/// Most pulses beyond a block from which states at the opening of windows are found.
const MOST_BEYOND: f64 = 4096.0;

/// What an export did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exported {
    /// Pulses in the file.
    pub pulses: u64,
    /// Its length, bytes.
    pub bytes: u64,
}

/// The columns of a recording that are read.
struct Table<'a> {
    path: &'a Path,
    source: &'a Source,
    columns: Vec<Column>,
    description: &'a Description,
}

/// Writes the pulses of a recording into a new file `at`, of which errors speak as `to`.
///
/// # Errors
/// What the recording lacks or does not hold, what CRSD cannot express, and what the system refuses.
pub fn export(
    recording: &Path,
    description: Description,
    at: &Path,
    to: &Path,
) -> Result<Exported, CrsdError> {
    let source = Source::open(recording)?;
    let columns = columns(source.header());
    let table = Table { path: recording, source: &source, columns, description: &description };
    let all = source.pulses();
    let planned = table.planned(all)?;
    let block = (BLOCK_BYTES / table.column("iq")?.row_bytes().max(1)).clamp(1, BLOCK_PULSES);
    let file = OpenOptions::new().read(true).write(true).create_new(true).open(at);
    let file = file.map_err(CrsdError::io(to, "making the file"))?;
    let mut writer = Writer::new(to, file, description.clone(), &planned)?;
    for first in (0..all).step_by(block) {
        let used = first..(first + block).min(all);
        let rows = table.pulses(used.clone(), all)?;
        let samples = table.rows("iq", used.clone())?;
        let begin = used.start.saturating_sub(BEFORE);
        let width = table.column("iq")?.width();
        for (place, row) in used.clone().enumerate() {
            let of = place * width..(place + 1) * width;
            let samples = match &samples {
                Rows::Cf32(values) => values.get(of).map(PulseSamples::Cf32),
                Rows::Ci16(codes) => codes.get(of).map(PulseSamples::Ci16),
                _ => None,
            };
            let samples = samples.ok_or_else(|| table.foreign("iq has too few samples".to_owned()))?;
            writer.push(&rows, row - begin, samples)?;
        }
    }
    let pulses = writer.pulses();
    Ok(Exported { pulses, bytes: writer.finish()? })
}

impl Table<'_> {
    fn foreign(&self, detail: String) -> CrsdError {
        RecordingError::Foreign { path: self.path.to_owned(), detail }.into()
    }

    fn missing(&self, name: &str) -> CrsdError {
        RecordingError::Missing { path: self.path.to_owned(), column: name.to_owned() }.into()
    }

    fn column(&self, name: &str) -> Result<&Column, CrsdError> {
        let known = self.columns.iter().find(|column| column.path == name);
        let known = known.filter(|column| !column.may_be_missing() || self.source.has(column));
        known.ok_or_else(|| self.missing(name))
    }

    fn rows(&self, name: &str, rows: Range<usize>) -> Result<Rows, CrsdError> {
        let column = self.column(name)?;
        self.source.holds(self.path, column, &rows)?;
        Ok(self.source.rows(self.path, column, rows)?)
    }

    fn reals<const N: usize>(&self, name: &str, rows: Range<usize>) -> Result<Vec<[f64; N]>, CrsdError> {
        let count = rows.len();
        match self.rows(name, rows)? {
            Rows::F64(values) if values.len() == count * N => Ok(values.as_chunks::<N>().0.to_vec()),
            _ => Err(self.foreign(format!("{name} has not {N} numbers for each pulse"))),
        }
    }

    /// Starts of the windows of the channels, s after emissions.
    fn windows(&self, rows: Range<usize>) -> Result<Vec<[f64; 1]>, CrsdError> {
        let Some(width) = self.columns.iter().find(|of| of.path == RECEIVER_WINDOWS).map(Column::width)
        else {
            return self.reals::<1>("pulse/window_start_s", rows);
        };
        let count = rows.len();
        match self.rows(RECEIVER_WINDOWS, rows)? {
            Rows::F64(all) if all.len() == count * width => {
                Ok(all.iter().skip(self.description.receiver()).step_by(width).map(|s| [*s]).collect())
            }
            _ => Err(self.foreign(format!("{RECEIVER_WINDOWS} has not {width} numbers for each pulse"))),
        }
    }

    /// Pulses of every sequence.
    fn planned(&self, all: usize) -> Result<Vec<u64>, CrsdError> {
        let mut planned = vec![0; self.description.sequences.len()];
        for first in (0..all).step_by(BLOCK_PULSES) {
            let Rows::U8(codes) = self.rows("pulse/tx_pol", first..(first + BLOCK_PULSES).min(all))? else {
                return Err(self.missing("pulse/tx_pol"));
            };
            for code in codes {
                for (sequence, count) in planned.iter_mut().enumerate() {
                    *count += u64::from(self.description.is_in(code, sequence));
                }
            }
        }
        Ok(planned)
    }

    /// Rows of some pulses, of [`BEFORE`] before them, and of those after them up to where their windows
    /// open.
    fn pulses(&self, used: Range<usize>, all: usize) -> Result<Vec<PulseRow>, CrsdError> {
        let windows = self.windows(used.clone())?;
        let latest_s = windows.iter().fold(0.0_f64, |latest, [start]| latest.max(*start));
        // A sequence of intervals may have short ones next to each other.
        let beyond = (4.0 * latest_s * self.description.header.prf_hz).ceil().clamp(1.0, MOST_BEYOND);
        let range = used.start.saturating_sub(BEFORE)..(used.end + beyond as usize + BEYOND).min(all);
        let (index, time_ns) =
            match (self.rows("pulse/index", range.clone())?, self.rows("pulse/time_ns", range.clone())?) {
                (Rows::U64(index), Rows::I64(time_ns)) => (index, time_ns),
                _ => return Err(self.foreign("numbers or times of pulses are no whole numbers".to_owned())),
            };
        let Rows::U8(tx_pol) = self.rows("pulse/tx_pol", range.clone())? else {
            return Err(self.missing("pulse/tx_pol"));
        };
        let Rows::U32(flags) = self.rows("pulse/flags", range.clone())? else {
            return Err(self.missing("pulse/flags"));
        };
        let parts_ns = self.reals::<1>("pulse/time_frac_ns", range.clone())?;
        let windows = self.windows(range.clone())?;
        let mut rows: Vec<PulseRow> = Vec::with_capacity(range.len());
        for place in 0..range.len() {
            let ([part_ns], [window_start_s]) = (parts_ns[place], windows[place]);
            let time = recorded_time(time_ns[place], part_ns);
            if let Some(last) = rows.last()
                && !(last.index < index[place] && time.since(last.time) > 0.0)
            {
                let detail = format!("pulse {} and its time do not ascend", index[place]);
                return Err(self.foreign(detail));
            }
            rows.push(PulseRow {
                index: index[place],
                time,
                window_start_s,
                tx_pol: tx_pol[place],
                flags: flags[place],
                antennas: Vec::with_capacity(self.description.ends.len()),
            });
        }
        for end in &self.description.ends {
            let (name, platform) = (&end.name, &end.platform);
            let centres = self.reals::<3>(&format!("nav/{name}/reported_phase_centre_m"), range.clone())?;
            let axes = self.reals::<4>(&format!("nav/{name}/boresight_quat"), range.clone())?;
            let truth = self.reals::<4>(&format!("nav/{platform}/true/attitude_quat"), range.clone())?;
            let reported =
                self.reals::<4>(&format!("nav/{platform}/reported/attitude_quat"), range.clone())?;
            let speeds = self.reals::<3>(&format!("nav/{platform}/reported/velocity_mps"), range.clone())?;
            for (place, row) in rows.iter_mut().enumerate() {
                let antenna = AntennaRow::new(
                    centres[place],
                    speeds[place],
                    axes[place],
                    truth[place],
                    reported[place],
                );
                row.antennas.push(antenna);
            }
        }
        Ok(rows)
    }
}
