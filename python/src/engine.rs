//! A scenario that was read: checked, streamed, recorded, mapped.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crossbeam_channel::{RecvTimeoutError, bounded};
use nereus::Scenario;
use nereus::cli::{assess, sea_at};
use nereus::sinks::Kind;
use nereus::transport::Pace;
use nereus::transport::pacer::Status;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

use crate::fault::{self, InputError, detached, guarded};
use crate::stream::Stream;
use crate::{loads, object};

/// How often a recording looks for Ctrl-C.
const GLANCE: Duration = Duration::from_millis(100);

/// A scenario that was read and is free of faults of its text.
#[pyclass(frozen, module = "nereus._nereus")]
pub(crate) struct Engine(Scenario);

/// What a recording came to.
#[derive(Serialize)]
struct Recorded<'a> {
    #[serde(flatten)]
    summary: &'a nereus::transport::stage::Summary,
    files: Vec<PathBuf>,
}

impl Engine {
    /// Pulses that are asked for, of all.
    fn range(&self, pulses: Option<(u64, u64)>) -> Range<u64> {
        pulses.map_or(0..self.0.pulses(), |(first, end)| first..end)
    }
}

#[pymethods]
impl Engine {
    /// Reads `text`, or the file `path` without it, and puts `overrides` (key, TOML) on it.
    #[new]
    fn new(
        py: Python<'_>,
        text: Option<String>,
        path: PathBuf,
        overrides: Vec<(String, String)>,
    ) -> PyResult<Self> {
        detached(py, fault::scenario, || {
            let read = match text {
                Some(text) => Scenario::parse(&text, &path, &overrides),
                None => {
                    let borrowed: Vec<(&str, &str)> =
                        overrides.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
                    Scenario::load(&path, &borrowed)
                }
            };
            read.map(Self)
        })
    }

    /// Pulses of the run.
    #[getter]
    fn pulses(&self) -> u64 {
        self.0.pulses()
    }

    /// The scenario as it is recorded: TOML, with its overrides.
    #[getter]
    fn text(&self) -> &str {
        &self.0.0.text
    }

    /// Warnings of the text alone.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.0.warnings.iter().map(ToString::to_string).collect()
    }

    /// What `nereus check` reports: text, and the same as a dict.
    fn check<'py>(&self, py: Python<'py>) -> PyResult<(String, Bound<'py, PyAny>)> {
        let report = detached(py, fault::command, || assess(&self.0.0, |_| ()))?;
        let text = report.text();
        Ok((text, loads(py, &report.json().map_err(fault::command)?)?))
    }

    /// A stream of pulses, under way.
    fn stream(&self, py: Python<'_>, realtime: bool, pulses: Option<(u64, u64)>) -> PyResult<Stream> {
        let pace = if realtime { Pace::Realtime } else { Pace::Fast };
        let range = self.range(pulses);
        detached(py, fault::scenario, || self.0.released(range, pace)).map(Stream::new)
    }

    /// Records pulses. `progress` is called with (passed, total, late, dropped).
    #[pyo3(signature = (path, hdf5, pulses, force, progress))]
    fn record<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        hdf5: bool,
        pulses: Option<(u64, u64)>,
        force: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if hdf5 && !cfg!(feature = "hdf5") {
            let what = format!(
                "this build has no HDF5: {} cannot be an HDF5 file; allowed: a folder",
                path.display()
            );
            return Err(InputError::new_err(what));
        }
        let kind =
            if hdf5 { Kind::Hdf5 { path, segment_s: None, force } } else { Kind::Plain { path, force } };
        let (stop, range, scenario) = (Arc::new(AtomicBool::new(false)), self.range(pulses), self.0.clone());
        let (sender, statuses) = bounded::<Status>(8);
        let asked = Arc::clone(&stop);
        let run = thread::Builder::new()
            .name("recording".to_owned())
            .spawn(move || scenario.record(range, kind, &asked, Some(sender)))
            .map_err(fault::internal)?;
        let mut met = Ok(());
        loop {
            let status = py.detach(|| statuses.recv_timeout(GLANCE));
            if met.is_ok() {
                met = py.check_signals().and_then(|()| match (&status, &progress) {
                    (Ok(Status { passed, total, late, dropped }), Some(progress)) => {
                        progress.call1(py, (*passed, *total, *late, *dropped)).map(|_| ())
                    }
                    _ => Ok(()),
                });
                if met.is_err() {
                    // The recording is closed with the pulses so far before the exception goes on.
                    stop.store(true, Ordering::Release);
                }
            }
            if matches!(status, Err(RecvTimeoutError::Disconnected)) {
                break;
            }
        }
        let outcome = py.detach(|| run.join()).map_err(|_| fault::internal("the recording panicked"));
        met?;
        let outcome = outcome?.map_err(fault::scenario)?;
        let files = outcome.reports.iter().filter_map(|(_, report)| report.as_ref());
        let files = files.flat_map(|report| report.files.clone()).collect();
        outcome.result.map_err(|error| fault::scenario(nereus::ScenarioError::Run(Box::new(error))))?;
        object(py, &Recorded { summary: &outcome.summary, files })
    }

    /// The sea at a time: axes, fields, units, and figures.
    #[expect(clippy::type_complexity, reason = "what Python unpacks at once")]
    fn sea<'py>(
        &self,
        py: Python<'py>,
        time_s: f64,
    ) -> PyResult<(
        Bound<'py, PyArray1<f64>>,
        Bound<'py, PyArray1<f64>>,
        Bound<'py, PyDict>,
        Bound<'py, PyDict>,
        Bound<'py, PyAny>,
    )> {
        let map = detached(py, fault::command, || sea_at(&self.0.0, time_s))?;
        guarded(|| {
            let [x_m, y_m] = map.axes_m();
            let (fields, units) = (PyDict::new(py), PyDict::new(py));
            for layer in map.layers() {
                let values = PyArray1::from_slice(py, layer.values).reshape([y_m.len(), x_m.len()])?;
                fields.set_item(layer.name, values)?;
                units.set_item(layer.name, layer.unit)?;
            }
            let figures = object(py, &map.summary())?;
            Ok((x_m.into_pyarray(py), y_m.into_pyarray(py), fields, units, figures))
        })
    }
}
