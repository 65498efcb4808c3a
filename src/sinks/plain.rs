//! A recording as a folder of plain files, for machines without HDF5.
//!
//! `meta.json` holds the header and, under `columns`, the type and row shape of every per-pulse file.
//! Column `a/b` is the file `a/b.bin`: rows one after the other in C order, without any header, so
//!
//! ```python
//! import json, numpy as np
//! meta = json.load(open("rec/meta.json"))
//! n = np.fromfile("rec/pulse/index.bin", "<u8").size
//! iq = np.fromfile("rec/iq.bin", meta["columns"]["iq"]["dtype"])
//! iq = iq[: n * iq_width].reshape(n, *meta["columns"]["iq"]["shape"])
//! ```
//!
//! Codes of a converter are pairs of i2: a trailing axis of 2 (in-phase, quadrature). `replica.bin` is
//! complex64. `pulse/index.bin` is written last at every flush
//! ([`FLUSH_INTERVAL`]): after a kill the first `n` rows of every file are
//! complete, n being its length. The columns are listed in [`super::columns`]. Where reports may be changed, `truth/changes.jsonl` has a line for every
//! change up to the last pulse: `{"pulse":2220,"time_ns":..,"platform":"aircraft","text":"step position.up 5 m","source":"scenario"}`.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Map, Value, json};

use crate::pulse::Pulse;

use super::columns::{Column, Element, Rows, columns};
use super::sink::{FLUSH_INTERVAL, FORMAT_VERSION, Header, Sink, SinkError, SinkReport};
use super::unwritten::Unwritten;

/// Rows wait in memory until this many bytes are there (or a flush is due).
const BUFFER_BYTES: usize = 1 << 20;

/// A folder of plain files.
#[derive(Debug)]
pub struct PlainSink {
    path: PathBuf,
    /// In the order of [`columns`]: the index last.
    files: Vec<PlainFile>,
    buffered_bytes: usize,
    row_bytes: usize,
    pulses: u64,
    flushed: Instant,
    changes: Option<Changes>,
}

/// The file of changes.
#[derive(Debug)]
struct Changes {
    unwritten: Unwritten,
    path: PathBuf,
    file: File,
}

#[derive(Debug)]
struct PlainFile {
    column: Column,
    rows: Rows,
    path: PathBuf,
    file: File,
}

/// Whether a folder may be made (or made anew) here.
pub(super) fn preflight(path: &Path, force: bool) -> Result<(), SinkError> {
    if fs::symlink_metadata(path).is_err() {
        return super::parent_exists(path);
    }
    if !force {
        return Err(SinkError::Exists { path: path.to_owned() });
    }
    let is_empty = fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none());
    let is_recording = fs::read(path.join("meta.json"))
        .ok()
        .and_then(|text| serde_json::from_slice::<Value>(&text).ok())
        .is_some_and(|meta| meta["format"] == "nereus");
    if is_empty || is_recording { Ok(()) } else { Err(SinkError::NotARecording { path: path.to_owned() }) }
}

impl PlainSink {
    /// Makes the folder; nothing is left of it when that fails.
    pub fn create(path: &Path, force: bool, header: &Header) -> Result<Self, SinkError> {
        header.check()?;
        preflight(path, force)?;
        if fs::symlink_metadata(path).is_ok() {
            fs::remove_dir_all(path).map_err(SinkError::io(path, "removing the old recording"))?;
        }
        let made = Self::fill(path, header);
        if made.is_err() {
            let _ = fs::remove_dir_all(path);
        }
        made
    }

    fn fill(path: &Path, header: &Header) -> Result<Self, SinkError> {
        fs::create_dir(path).map_err(SinkError::io(path, "making the folder"))?;
        let write = |name: &str, bytes: &[u8]| {
            let file = path.join(name);
            fs::write(&file, bytes).map_err(SinkError::io(&file, "writing"))
        };
        write("replica.bin", bytemuck::cast_slice(&header.replica))?;
        let list = columns(header);
        let meta = format!("{:#}\n", meta(header, &list));
        write("meta.json", meta.as_bytes())?;
        let row_bytes: usize = list.iter().map(Column::row_bytes).sum();
        let rows_kept = BUFFER_BYTES.div_ceil(row_bytes);
        let mut files = Vec::with_capacity(list.len());
        for column in list {
            let file_path = path.join(format!("{}.bin", column.path));
            if let Some(folder) = file_path.parent() {
                fs::create_dir_all(folder).map_err(SinkError::io(folder, "making the folder"))?;
            }
            let file = File::create_new(&file_path).map_err(SinkError::io(&file_path, "making the file"))?;
            let rows = Rows::with_capacity(column.element, column.width() * rows_kept);
            files.push(PlainFile { column, rows, path: file_path, file });
        }
        let changes = match &header.changes {
            None => None,
            Some(log) => {
                let file_path = path.join("truth/changes.jsonl");
                fs::create_dir_all(path.join("truth")).map_err(SinkError::io(path, "making the folder"))?;
                let file =
                    File::create_new(&file_path).map_err(SinkError::io(&file_path, "making the file"))?;
                Some(Changes { unwritten: Unwritten::of(log), path: file_path, file })
            }
        };
        Ok(Self {
            changes,
            path: path.to_owned(),
            files,
            buffered_bytes: 0,
            row_bytes,
            pulses: 0,
            flushed: Instant::now(),
        })
    }
}

impl Sink for PlainSink {
    fn name(&self) -> &'static str {
        "plain"
    }

    fn describe(&self) -> String {
        format!("plain recording {}", self.path.display())
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        for file in &self.files {
            file.column.check(pulse)?;
        }
        if let Some(Changes { unwritten, path, file }) = &mut self.changes {
            for entry in unwritten.up_to(pulse.index) {
                writeln!(file, "{}", json!(entry)).map_err(SinkError::io(path, "writing"))?;
            }
        }
        for file in &mut self.files {
            file.column.push(pulse, &mut file.rows);
        }
        self.pulses += 1;
        self.buffered_bytes += self.row_bytes;
        if self.buffered_bytes >= BUFFER_BYTES || self.flushed.elapsed() >= FLUSH_INTERVAL {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        for file in &mut self.files {
            file.file.write_all(file.rows.as_bytes()).map_err(SinkError::io(&file.path, "writing"))?;
            file.rows.clear();
        }
        self.buffered_bytes = 0;
        self.flushed = Instant::now();
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<SinkReport, SinkError> {
        self.flush()?;
        for file in &self.files {
            file.file.sync_all().map_err(SinkError::io(&file.path, "closing"))?;
        }
        Ok(SinkReport {
            name: "plain".to_owned(),
            pulses: self.pulses,
            bytes: self.pulses * self.row_bytes as u64,
            files: vec![self.path.clone()],
            wire: None,
            port: None,
        })
    }
}

/// `meta.json`.
fn meta(header: &Header, list: &[Column]) -> Value {
    let (start_ns, start_frac_ns) = header.start.to_unix_ns();
    let files: Map<String, Value> = list
        .iter()
        .map(|column| {
            let mut shape = column.shape.clone();
            if column.element == Element::Ci16 {
                shape.push(2);
            }
            (column.path.clone(), json!({ "dtype": column.element.numpy(), "shape": shape }))
        })
        .collect();
    json!({
        "format": "nereus",
        "version": FORMAT_VERSION,
        "software": header.software,
        "carrier_hz": header.carrier_hz,
        "sample_rate_hz": header.sample_rate_hz,
        "bandwidth_hz": header.bandwidth_hz,
        "pulse_s": header.pulse_s,
        "prf_hz": header.prf_hz,
        "channels": header.channels.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "channel": header.channels,
        "pairs": header.pairs,
        "origin_lat_deg": header.origin.map(|o| o.lat_deg),
        "origin_lon_deg": header.origin.map(|o| o.lon_deg),
        "origin_h_m": header.origin.map(|o| o.h_m),
        "seed": header.seed,
        "config": header.config,
        "platforms": header.platforms,
        "transmitters": header.transmitters,
        "receivers": header.receivers,
        "targets": header.targets,
        "ships": header.ships,
        "clocks": header.clocks,
        "adc_bits": header.adc.map(|a| a.bits),
        "adc_step": header.adc.map(|a| a.step),
        "start_time_ns": start_ns,
        "start_time_frac_ns": start_frac_ns,
        "first_pulse": header.first_pulse,
        "truth": header.truth,
        "pulses": header.pulses,
        "replica_dtype": Element::Cf32.numpy(),
        "columns": files,
    })
}
