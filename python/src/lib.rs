//! The engine of `nereus` in the process of Python: what the package `nereus` is built on.
//!
//! What is here hands over: a run's pulses with their memory, texts of reports, faults as exceptions. What
//! a user calls is in `python/nereus`. Nothing that takes long holds the GIL, and a panic becomes
//! `nereus.InternalError`.

mod command;
mod engine;
mod fault;
mod pulse;
mod receive;
mod stream;

use pyo3::prelude::*;
use serde::Serialize;

/// A report as Python sees it, through JSON.
pub(crate) fn object<'py>(py: Python<'py>, report: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    loads(py, &serde_json::to_string(report).map_err(fault::internal)?)
}

/// What a JSON text says.
pub(crate) fn loads<'py>(py: Python<'py>, json: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (json,))
}

/// The engine of nereus.
#[pymodule]
mod _nereus {
    #[pymodule_export]
    use crate::command::{_panic, command, inline_toml, main, toml};
    #[pymodule_export]
    use crate::engine::Engine;
    #[pymodule_export]
    use crate::pulse::{Antenna, Platform, Pulse, Ship};
    #[pymodule_export]
    use crate::receive::Reception;
    #[pymodule_export]
    use crate::stream::Stream;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        // Recordings from elsewhere are read by a process of their own first.
        let python: std::ffi::OsString = module.py().import("sys")?.getattr("executable")?.extract()?;
        if !python.is_empty() {
            nereus::recording::examination::called_by(vec![python, "-m".into(), "nereus".into()]);
        }
        Ok(())
    }
}
