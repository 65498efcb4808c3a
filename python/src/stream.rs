//! A stream of pulses under way.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use nereus::pipeline::control::Control;
use nereus::pipeline::released::{ReleasedPulses, Taken};
use nereus::recording::header::Header;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault::{self, InputError, StreamClosed, detached, guarded};
use crate::object;
use crate::pulse::{Pulse, described};

/// How often a wait for a pulse looks for Ctrl-C.
const GLANCE: Duration = Duration::from_millis(50);

/// Pulses of a run, in order, as they are released.
///
/// An iterator of `Pulse`, and a context manager that closes the run. While a pulse is waited for, other
/// threads of Python go on, and Ctrl-C works.
#[pyclass(frozen, module = "nereus")]
pub(crate) struct Stream {
    pulses: Mutex<ReleasedPulses>,
    control: Option<Control>,
    stop: Arc<AtomicBool>,
    closed: AtomicBool,
    header: Arc<Header>,
    described: OnceLock<Py<PyDict>>,
}

impl Stream {
    pub(crate) fn new(pulses: ReleasedPulses) -> Self {
        Self {
            control: pulses.control(),
            stop: pulses.stop(),
            closed: AtomicBool::new(false),
            header: Arc::new(pulses.header().clone()),
            pulses: Mutex::new(pulses),
            described: OnceLock::new(),
        }
    }

    fn open(&self) -> PyResult<()> {
        if self.closed.load(Ordering::Acquire) {
            let what = "the stream is closed; allowed: an open one: Scenario.stream() starts another";
            return Err(StreamClosed::new_err(what));
        }
        Ok(())
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        let pulses = self.pulses.get_mut().unwrap_or_else(PoisonError::into_inner);
        // The run ends with the block under way: other threads of Python do not wait for it. An interpreter
        // that ends has none, and the run ends with what is dropped.
        Python::try_attach(|py| py.detach(|| drop(pulses.close())));
    }
}

#[pymethods]
impl Stream {
    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Pulse>> {
        loop {
            self.open()?;
            let taken = detached(py, fault::scenario, || {
                self.pulses.lock().unwrap_or_else(PoisonError::into_inner).next_within(GLANCE)
            })?;
            match taken {
                Taken::Pulse(pulse) => return guarded(|| Pulse::new(py, pulse, &self.header)).map(Some),
                Taken::Ended => return Ok(None),
                Taken::Waiting => py.check_signals()?,
            }
        }
    }

    fn __enter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, PyAny>) -> PyResult<bool> {
        self.close(py)?;
        Ok(false)
    }

    /// Ends the run, if it has not ended. A second call does nothing.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.closed.store(true, Ordering::Release);
        self.stop.store(true, Ordering::Release);
        detached(py, fault::scenario, || {
            self.pulses.lock().unwrap_or_else(PoisonError::into_inner).close().map(|_| ())
        })
    }

    /// Whether the stream was closed.
    #[getter]
    fn closed(&self) -> bool {
        self.closed.load(Ordering::Acquire)
    }

    /// Changes what a platform reports, from the first pulse that no worker has begun, and returns its index.
    ///
    /// `change` is a line such as `"step position.up 5 m on aircraft"` (docs/control.md).
    fn inject(&self, py: Python<'_>, change: &str) -> PyResult<u64> {
        self.open()?;
        let Some(control) = &self.control else {
            return Err(fault::internal("a stream without control"));
        };
        let raise = |error: nereus::pipeline::control::ControlError| InputError::new_err(error.to_string());
        detached(py, raise, || control.line(change)).map(|(pulse, _)| pulse)
    }

    /// Counters of the run: pulses released, late, dropped, made; lateness, sinks. Empty before the first
    /// pulse is made.
    fn health<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self.control.as_ref().and_then(Control::health) {
            Some(health) => object(py, &health),
            None => Ok(PyDict::new(py).into_any()),
        }
    }

    /// Figures of the run once it has ended, else None.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let summary =
            py.detach(|| self.pulses.lock().unwrap_or_else(PoisonError::into_inner).summary().cloned());
        summary.map(|summary| object(py, &summary)).transpose()
    }

    /// What the pulses are: carrier, sample rate, names of channels, platforms, antennas and targets,
    /// replica.
    #[getter]
    fn info(&self, py: Python<'_>) -> PyResult<Py<PyDict>> {
        if let Some(known) = self.described.get() {
            return Ok(known.clone_ref(py));
        }
        let made = guarded(|| described(py, &self.header))?.unbind();
        Ok(self.described.get_or_init(|| made).clone_ref(py))
    }

    fn __repr__(&self) -> String {
        let Header { channels, layout, first_pulse, pulses, .. } = &*self.header;
        let state = if self.closed() { "closed" } else { "open" };
        format!(
            "<nereus.Stream, {state}: pulses {first_pulse} to {}, {} channels of {} samples>",
            first_pulse + pulses.saturating_sub(1),
            channels.len(),
            layout.samples
        )
    }
}
