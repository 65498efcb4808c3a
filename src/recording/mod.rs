//! Files of pulses, maps and images: HDF5 and plain folders, written and read by the same description.
//!
//! [`header`] holds for a whole recording, [`descriptions`] lists its datasets, `hdf5` and [`plain`] write
//! and read the files. [`Recording`] reads a part of one for processing.
//!
//! Some rows beyond those asked for are read of all columns but the samples, so that paths are known before
//! the first and after the last pulse of a part. Samples are read in blocks of rows, and only the channels
//! asked for are kept: 8 bytes per sample.
//!
//! Phase centres: `/nav/<antenna>/phase_centre_m` is the true one, `reported_phase_centre_m` what the
//! platform's reports make of it with the lever arm as designed.
//!
//! ```no_run
//! use nereus::recording::Recording;
//! let recording = Recording::open("calibration.h5".as_ref(), Some(0..500))?;
//! let path = recording.true_path("airborne")?;
//! println!("{} pulses, receiver at {:?} m", recording.pulses(), path.at(0.5));
//! # Ok::<(), nereus::recording::RecordingError>(())
//! ```

#[doc(hidden)]
pub mod columns;
#[doc(hidden)]
pub mod crsd;
#[doc(hidden)]
pub mod descriptions;
#[doc(hidden)]
pub mod examination;
mod fault;
#[doc(hidden)]
pub mod field_file;
pub mod ground;
#[cfg(feature = "hdf5")]
#[doc(hidden)]
pub mod hdf5;
pub mod header;
#[doc(hidden)]
pub mod image_file;
pub mod instrument;
#[doc(hidden)]
pub mod map_file;
#[cfg(feature = "hdf5")]
#[doc(hidden)]
pub mod merge;
#[doc(hidden)]
pub mod output;
#[doc(hidden)]
pub mod path_file;
#[doc(hidden)]
pub mod plain;
mod released;
mod rows;
#[doc(hidden)]
#[doc(hidden)]
pub mod shard;
pub mod sigmf;
#[doc(hidden)]
pub mod snapshot_file;
pub(crate) mod source;
mod unwritten;
pub mod verify;

pub use fault::RecordingError;
pub use plain::plain_header;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use num_complex::Complex32;

use crate::geometry::phase_path::PhasePath;
use crate::scene::radar::Polarisation;
use columns::{Column, Rows, columns};
use header::Header;
use source::Source;

/// Rows read beyond those asked for.
const AROUND: usize = 64;
/// Longest recording, and farthest window from its emission, s.
const LONGEST_S: f64 = 1e8;
/// Column of the windows of receivers, where these differ.
pub(crate) const RECEIVER_WINDOWS: &str = "pulse/receiver_window_start_s";
/// Samples of all channels that are read at a time, bytes in the file.
const BLOCK_BYTES: usize = 4 << 20;

/// Whether a pulse leaves after the one before it (s after the first that was read), and its window opens
/// some time about then; else what is wrong.
fn check_instants(
    number: u64,
    before_s: Option<f64>,
    emission_s: f64,
    window_start_s: f64,
) -> Result<(), String> {
    let ascends = before_s.is_none_or(|before_s| before_s < emission_s);
    if !(ascends && (0.0..=LONGEST_S).contains(&emission_s)) {
        return Err(format!(
            "pulse {number} leaves {emission_s:?} s after those before it were read; allowed: ascending, within {LONGEST_S} s"
        ));
    }
    if !(-LONGEST_S..=LONGEST_S).contains(&window_start_s) {
        return Err(format!(
            "pulse/window_start_s of pulse {number} is {window_start_s:?}; allowed: within {LONGEST_S} s of the emission"
        ));
    }
    Ok(())
}

/// A part of a recording in memory.
pub struct Recording {
    path: PathBuf,
    /// What holds for the whole recording.
    pub header: Header,
    /// Number of each pulse in use.
    pub index: Vec<u64>,
    /// Emission of each pulse in use, s after [`Self::path_s`]'s zero.
    pub emission_s: Vec<f64>,
    /// First sample after the emission, s: of all channels, or of the first ([`Self::window_start_of`]).
    pub window_start_s: Vec<f64>,
    /// Code of the polarisation that left, 0 for all.
    pub tx_pol: Vec<u8>,
    /// Emissions of all rows that paths know, s.
    pub path_s: Vec<f64>,
    /// Emission of pulse 0 of the run on the same clock, s.
    start_s: f64,
    /// Place of the pulses in use among those rows.
    rows: Range<usize>,
    numbers: BTreeMap<String, (usize, Vec<f64>)>,
    /// Flags of pulses and platforms, of the same rows.
    flags: BTreeMap<String, Vec<u32>>,
    /// Emission of the first of those rows, UTC nanoseconds since 1970, rounded down.
    zero_ns: i64,
    /// Channels whose samples are held.
    channels: Vec<usize>,
    samples: Vec<Complex32>,
}

/// Samples of some channels, pulse by pulse.
fn samples(
    path: &Path,
    source: &Source,
    list: &[Column],
    rows: Range<usize>,
    channels: &[usize],
    most_bytes: Option<u64>,
) -> Result<Vec<Complex32>, RecordingError> {
    let header = source.header();
    let count = rows.len().saturating_mul(channels.len()).saturating_mul(header.layout.samples);
    let needed = (count as u64).saturating_mul(size_of::<Complex32>() as u64);
    let too_many = |available: u64| RecordingError::Memory {
        path: path.to_owned(),
        channels: channels.len(),
        pulses: rows.len(),
        needed_mib: needed.div_ceil(1 << 20),
        available_mib: available >> 20,
    };
    if let Some(available) = most_bytes.filter(|most| needed > *most) {
        return Err(too_many(available));
    }
    let Some(column) = list.iter().find(|column| column.path == "iq") else {
        return Err(RecordingError::Missing { path: path.to_owned(), column: "iq".to_owned() });
    };
    source.holds(path, column, &rows)?;
    // Mid-rise: a code stands for the middle of its step.
    let step = header.adc.map_or(1.0, |adc| adc.step) as f32;
    let level = |code: i16| (f32::from(code) + 0.5) * step;
    let mut samples = Vec::new();
    samples.try_reserve_exact(count).map_err(|_| too_many(most_bytes.unwrap_or(0)))?;
    let block = (BLOCK_BYTES / column.row_bytes().max(1)).max(1);
    for first in rows.clone().step_by(block) {
        let read = source.rows(path, column, first..(first + block).min(rows.end))?;
        let row = header.layout.samples * header.layout.channels;
        let windows = |pulse: usize| {
            channels.iter().map(move |channel| {
                let at = pulse * row + channel * header.layout.samples;
                at..at + header.layout.samples
            })
        };
        for place in (0..(first + block).min(rows.end) - first).flat_map(windows) {
            match &read {
                Rows::Cf32(values) => samples.extend_from_slice(values.get(place).unwrap_or_default()),
                Rows::Ci16(codes) => {
                    let codes = codes.get(place).unwrap_or_default();
                    samples.extend(codes.iter().map(|code| Complex32::new(level(code.re), level(code.im))));
                }
                _ => {}
            }
        }
    }
    Ok(samples)
}

impl Recording {
    /// Reads the pulses of a recording (by their numbers), or all of them, in all channels.
    ///
    /// # Errors
    /// A recording that cannot be read, is damaged, or has none of the pulses.
    pub fn open(path: &Path, pulses: Option<Range<u64>>) -> Result<Self, RecordingError> {
        Self::open_channels(path, pulses, None, |header| Ok((0..header.channels.len()).collect()))
    }

    /// The same with the samples of some channels only, chosen by the header, as long as they take no more
    /// than `most_bytes`.
    ///
    /// # Errors
    /// As [`Self::open`], what `choose` reports, and samples that need more memory.
    pub fn open_channels<E: From<RecordingError>>(
        path: &Path,
        pulses: Option<Range<u64>>,
        most_bytes: Option<u64>,
        choose: impl FnOnce(&Header) -> Result<Vec<usize>, E>,
    ) -> Result<Self, E> {
        let source = Source::open(path)?;
        let channels = choose(source.header())?;
        Ok(Self::read(path, &source, pulses, most_bytes, channels)?)
    }

    fn read(
        path: &Path,
        source: &Source,
        pulses: Option<Range<u64>>,
        most_bytes: Option<u64>,
        channels: Vec<usize>,
    ) -> Result<Self, RecordingError> {
        let header = source.header().clone();
        let list = columns(&header);
        let all = source.pulses();
        let read = |column: &str, rows: Range<usize>| match list.iter().find(|c| c.path == column) {
            Some(column) => source.rows(path, column, rows),
            None => Err(RecordingError::Missing { path: path.to_owned(), column: column.to_owned() }),
        };
        let index = match read("pulse/index", 0..all)? {
            Rows::U64(index) => index,
            _ => Vec::new(),
        };
        if let Some(pair) = index.windows(2).find(|pair| pair[1] <= pair[0]) {
            let detail =
                format!("pulse {} comes after pulse {}; a recording's pulses ascend", pair[1], pair[0]);
            return Err(RecordingError::Foreign { path: path.to_owned(), detail });
        }
        let asked = pulses.unwrap_or(0..u64::MAX);
        let used = index.partition_point(|i| *i < asked.start)..index.partition_point(|i| *i < asked.end);
        if used.is_empty() {
            let first = index.first().copied().unwrap_or(0);
            let end = index.last().map_or(first, |last| last.saturating_add(1));
            return Err(RecordingError::NoPulses { path: path.to_owned(), first, end, asked });
        }
        let known = used.start.saturating_sub(AROUND)..(used.end + AROUND).min(all);
        let (mut numbers, mut flags) = (BTreeMap::new(), BTreeMap::new());
        let (mut time_ns, mut tx_pol) = (Vec::new(), Vec::new());
        for column in list.iter().filter(|c| c.path != "iq") {
            if column.may_be_missing() && !source.has(column) {
                continue;
            }
            match source.rows(path, column, known.clone())? {
                Rows::F64(values) => {
                    numbers.insert(column.path.clone(), (column.width(), values));
                }
                Rows::I64(values) if column.path == "pulse/time_ns" => time_ns = values,
                Rows::U8(values) if column.path == "pulse/tx_pol" => tx_pol = values,
                Rows::U32(values) => {
                    flags.insert(column.path.clone(), values);
                }
                _ => {}
            }
        }
        let samples = samples(path, source, &list, used.clone(), &channels, most_bytes)?;
        let rows = used.start - known.start..used.end - known.start;
        let scalar = |name: &str| numbers.get(name).map(|(_, values)| values.clone()).unwrap_or_default();
        // Whole nanoseconds are taken apart as integers: seconds since 1970 in f64 would be rounded to 2e-7
        // s.
        let zero_ns = time_ns.first().copied().unwrap_or(0);
        let path_s: Vec<f64> = time_ns
            .iter()
            .zip(scalar("pulse/time_frac_ns"))
            .map(|(ns, part)| (ns.saturating_sub(zero_ns) as f64 + part) * 1e-9)
            .collect();
        let (start_ns, start_part) = header.start.to_unix_ns();
        let start_s = (start_ns.saturating_sub(zero_ns) as f64 + start_part) * 1e-9;
        let window_start_s = scalar("pulse/window_start_s");
        let foreign = |detail: String| RecordingError::Foreign { path: path.to_owned(), detail };
        if path_s.len() < rows.end || window_start_s.len() < rows.end || tx_pol.len() < rows.end {
            return Err(foreign("columns of /pulse have too few rows".to_owned()));
        }
        for row in rows.clone() {
            let before_s = row.checked_sub(1).map(|row| path_s[row]);
            let number = index[known.start + row];
            check_instants(number, before_s, path_s[row], window_start_s[row]).map_err(foreign)?;
            let own = numbers.get(RECEIVER_WINDOWS).map(|(width, values)| (*width, values));
            for start_s in
                own.and_then(|(width, values)| values.get(row * width..(row + 1) * width)).unwrap_or(&[])
            {
                check_instants(number, before_s, path_s[row], *start_s).map_err(foreign)?;
            }
        }
        Ok(Self {
            index: index[used].to_vec(),
            emission_s: path_s[rows.clone()].to_vec(),
            window_start_s: window_start_s[rows.clone()].to_vec(),
            tx_pol: tx_pol[rows.clone()].to_vec(),
            path: path.to_owned(),
            header,
            path_s,
            start_s,
            rows,
            numbers,
            flags,
            zero_ns,
            channels,
            samples,
        })
    }

    /// Emission of a pulse in use after that of pulse 0 of the run, s.
    pub(crate) fn since_start_s(&self, pulse: usize) -> f64 {
        self.emission_s[pulse] - self.start_s
    }

    /// Pulses in use.
    pub fn pulses(&self) -> usize {
        self.index.len()
    }

    /// Places of the channels whose samples were read.
    pub fn channels(&self) -> &[usize] {
        &self.channels
    }

    /// Samples of a channel in a pulse in use; none of a channel that was not read.
    pub fn window(&self, pulse: usize, channel: usize) -> &[Complex32] {
        let Some(place) = self.channels.iter().position(|held| *held == channel) else { return &[] };
        let samples = self.header.layout.samples;
        let at = (pulse * self.channels.len() + place) * samples;
        self.samples.get(at..at + samples).unwrap_or_default()
    }

    /// Start of the window of a channel after the emission of a pulse in use, s.
    pub fn window_start_of(&self, pulse: usize, channel: usize) -> f64 {
        let own = self.numbers.get(RECEIVER_WINDOWS).zip(self.header.receiver_of(channel));
        let own = own.and_then(|((width, values), receiver)| {
            values.get((self.rows.start + pulse) * width..)?.get(receiver).copied()
        });
        own.unwrap_or(self.window_start_s[pulse])
    }

    /// Whether a pulse was radiated in the polarisation of a channel.
    pub fn is_illuminated(&self, pulse: usize, channel: usize) -> bool {
        let radiated = self.tx_pol[pulse];
        let letter = self.header.channels.get(channel).and_then(|c| c.polarisations.chars().nth(1));
        radiated == 0 || letter.and_then(Polarisation::from_letter).is_none_or(|p| p.code() == radiated)
    }

    /// Path of an antenna's true phase centre.
    ///
    /// # Errors
    /// An antenna without that column, or positions that make no path.
    pub fn true_path(&self, antenna: &str) -> Result<PhasePath, RecordingError> {
        self.phase_path(self.points(&format!("nav/{antenna}/phase_centre_m"))?)
    }

    /// Path of an antenna's phase centre as its platform reports it.
    ///
    /// # Errors
    /// An antenna without that column, or positions that make no path.
    pub fn reported_path(&self, antenna: &str) -> Result<PhasePath, RecordingError> {
        self.phase_path(self.points(&format!("nav/{antenna}/reported_phase_centre_m"))?)
    }

    /// True boresight of an antenna in each pulse in use: unit vectors, ENU.
    ///
    /// # Errors
    /// An antenna without that column.
    pub fn boresights(&self, antenna: &str) -> Result<Vec<[f64; 3]>, RecordingError> {
        let (_, axes) = self.column(&format!("nav/{antenna}/boresight_quat"))?;
        let ahead = |q: &[f64; 4]| {
            let [w, x, y, z] = *q;
            (DQuat::from_xyzw(x, y, z, w).normalize() * DVec3::X).to_array()
        };
        let all: Vec<[f64; 3]> = axes.as_chunks::<4>().0.iter().map(ahead).collect();
        Ok(all.get(self.rows.clone()).map(<[_]>::to_vec).unwrap_or_default())
    }

    /// Position and velocity that a platform reports at a pulse in use, ENU, m and m/s.
    ///
    /// # Errors
    /// A platform without those columns.
    pub fn reported_state(
        &self,
        platform: &str,
        pulse: usize,
    ) -> Result<([f64; 3], [f64; 3]), RecordingError> {
        let row = self.rows.start + pulse;
        let at = |name: &str| {
            let points = self.points(&format!("nav/{platform}/reported/{name}"))?;
            Ok::<_, RecordingError>(points.get(row).copied().unwrap_or([f64::NAN; 3]))
        };
        Ok((at("position_m")?, at("velocity_mps")?))
    }

    /// Attitude that a platform reports at a pulse in use: body to ENU, scalar first.
    ///
    /// # Errors
    /// A platform without that column.
    pub(crate) fn reported_attitude(&self, platform: &str, pulse: usize) -> Result<[f64; 4], RecordingError> {
        let (_, values) = self.column(&format!("nav/{platform}/reported/attitude_quat"))?;
        Ok(values.as_chunks::<4>().0.get(self.rows.start + pulse).copied().unwrap_or([f64::NAN; 4]))
    }

    /// Azimuth and elevation that the encoder of an antenna reads at a pulse in use, rad.
    ///
    /// # Errors
    /// An antenna without that column: one that does not scan.
    pub(crate) fn encoder_rad(&self, antenna: &str, pulse: usize) -> Result<[f64; 2], RecordingError> {
        let (_, values) = self.column(&format!("nav/{antenna}/encoder_deg"))?;
        let reading_deg = values.as_chunks::<2>().0.get(self.rows.start + pulse);
        Ok(reading_deg.copied().unwrap_or([f64::NAN; 2]).map(f64::to_radians))
    }

    /// True delays of a target of a pair in the pulses in use, s; none where the recording has none.
    pub fn delays_s(&self, transmitter: &str, receiver: &str, target: usize) -> Option<Vec<f64>> {
        let pair = self
            .header
            .pairs
            .iter()
            .position(|pair| pair.transmitter == transmitter && pair.receiver == receiver)?;
        let (width, values) = self.numbers.get("truth/delay_s")?;
        let place = pair * self.header.targets.len() + target;
        let all: Vec<f64> = values.chunks_exact(*width).filter_map(|row| row.get(place).copied()).collect();
        all.get(self.rows.clone()).map(<[f64]>::to_vec)
    }

    fn column(&self, name: &str) -> Result<(usize, &[f64]), RecordingError> {
        match self.numbers.get(name) {
            Some((width, values)) => Ok((*width, values)),
            None => Err(RecordingError::Missing { path: self.path.clone(), column: name.to_owned() }),
        }
    }

    fn points(&self, name: &str) -> Result<Vec<[f64; 3]>, RecordingError> {
        let (_, values) = self.column(name)?;
        Ok(values.as_chunks::<3>().0.to_vec())
    }

    fn phase_path(&self, points_m: Vec<[f64; 3]>) -> Result<PhasePath, RecordingError> {
        PhasePath::new(self.path_s.clone(), points_m)
            .map_err(|source| RecordingError::Path { path: self.path.clone(), source })
    }
}
