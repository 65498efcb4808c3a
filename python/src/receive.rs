//! Pulses that come over the network as VITA 49.2.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};
use nereus::receive::Listener;
use nereus::receive::listener::{Interrupted, Opener, Senders, Until, senders};
use nereus::receive::report::Report;
use nereus::recording::header::Header;
use nereus::sinks::sink::{Closed, Sink, SinkError, SinkReport};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault::{self, InputError, RunError, StreamClosed, guarded};
use crate::object;
use crate::pulse::{Pulse, described};

/// Whole pulses that may wait for Python.
const WAITING: usize = 256;
/// How often a wait for a pulse looks for Ctrl-C.
const GLANCE: Duration = Duration::from_millis(50);

type Came = (Box<nereus::Pulse>, Arc<Header>);
type Ended = Result<Report, Box<Interrupted>>;

/// Takes the whole pulses of a run.
struct Taker {
    header: Arc<Header>,
    pulses: Sender<Came>,
}

impl Sink for Taker {
    fn name(&self) -> &'static str {
        "python"
    }

    fn describe(&self) -> String {
        "pulses to Python".to_owned()
    }

    fn write(&mut self, pulse: &nereus::Pulse) -> Result<(), SinkError> {
        // Who has closed the reception takes no more.
        let _ = self.pulses.send((Box::new(pulse.clone()), Arc::clone(&self.header)));
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        Ok(Closed::of(SinkReport::default()))
    }
}

fn opener(pulses: Sender<Came>) -> Opener {
    Box::new(move |header| Ok(Box::new(Taker { header: Arc::new(header.clone()), pulses }) as Box<dyn Sink>))
}

/// Whole pulses of a VITA 49.2 stream, in the order of their emission: an iterator and a context manager.
#[pyclass(frozen, module = "nereus")]
pub(crate) struct Reception {
    pulses: Mutex<Option<Receiver<Came>>>,
    thread: Mutex<Option<JoinHandle<Ended>>>,
    report: OnceLock<Report>,
    stop: Arc<AtomicBool>,
    address: String,
    header: Mutex<Option<Arc<Header>>>,
}

impl Reception {
    /// Waits for the end of the reception.
    fn end(&self) -> PyResult<()> {
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(thread) = thread else { return Ok(()) };
        match thread.join() {
            Ok(Ok(report)) => {
                let _ = self.report.set(report);
                Ok(())
            }
            Ok(Err(interrupted)) => {
                let _ = self.report.set(interrupted.report);
                Err(RunError::new_err(interrupted.error.to_string()))
            }
            Err(_) => Err(fault::internal("the reception panicked")),
        }
    }
}

#[pymethods]
impl Reception {
    #[new]
    #[pyo3(signature = (address, pulses=None, duration_s=None, idle_s=None, sender=None, restart=false))]
    fn new(
        address: &str,
        pulses: Option<u64>,
        duration_s: Option<f64>,
        idle_s: Option<f64>,
        sender: Option<&str>,
        restart: bool,
    ) -> PyResult<Self> {
        let span = |name: &str, seconds: Option<f64>| {
            let made = seconds.map(Duration::try_from_secs_f64).transpose();
            made.map_err(|_| InputError::new_err(format!("{name}: allowed: a number of seconds, 0 or more")))
        };
        let until =
            Until { pulses, duration: span("duration_s", duration_s)?, idle: span("idle_s", idle_s)? };
        let raise = |error: nereus::receive::ReceiveError| InputError::new_err(error.to_string());
        let from = sender.map(senders).transpose().map_err(raise)?;
        let (handed, pulses) = bounded(WAITING);
        let more = handed.clone();
        let next: Box<dyn Fn(usize) -> Opener + Send + Sync> = Box::new(move |_| opener(more.clone()));
        let senders = Senders { from, restart, next: restart.then_some(next), ..Senders::default() };
        let listener = Listener::bind(address).map_err(raise)?.with(senders);
        let address = listener.address().to_string();
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        let receive = move || listener.receive(until, &asked, Some(opener(handed)), |_| {});
        let thread = thread::Builder::new().name("reception".to_owned()).spawn(receive);
        Ok(Self {
            pulses: Mutex::new(Some(pulses)),
            thread: Mutex::new(Some(thread.map_err(fault::internal)?)),
            report: OnceLock::new(),
            stop,
            address,
            header: Mutex::new(None),
        })
    }

    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Pulse>> {
        loop {
            let taken = py.detach(|| {
                let pulses = self.pulses.lock().unwrap_or_else(PoisonError::into_inner);
                pulses.as_ref().map(|pulses| pulses.recv_timeout(GLANCE))
            });
            match taken {
                None => {
                    let what =
                        "the reception is closed; allowed: an open one: nereus.receive() starts another";
                    return Err(StreamClosed::new_err(what));
                }
                Some(Ok((pulse, header))) => {
                    let made = guarded(|| Pulse::new(py, pulse, &header));
                    *self.header.lock().unwrap_or_else(PoisonError::into_inner) = Some(header);
                    return made.map(Some);
                }
                Some(Err(RecvTimeoutError::Timeout)) => py.check_signals()?,
                Some(Err(RecvTimeoutError::Disconnected)) => {
                    return py.detach(|| self.end()).map(|()| None);
                }
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

    /// Ends the reception, if it has not ended. A second call does nothing.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.stop.store(true, Ordering::Release);
        py.detach(|| {
            *self.pulses.lock().unwrap_or_else(PoisonError::into_inner) = None;
            self.end()
        })
    }

    /// Where it listens.
    #[getter]
    fn address(&self) -> &str {
        &self.address
    }

    /// What the pulses are, as `Stream.info`; None before the first one.
    #[getter]
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let header = self.header.lock().unwrap_or_else(PoisonError::into_inner).clone();
        header.map(|header| guarded(|| described(py, &header))).transpose()
    }

    /// Gaps, order, lateness, sender, once the reception has ended, else None.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.report.get().map(|report| object(py, report)).transpose()
    }
}

impl Drop for Reception {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
    }
}
