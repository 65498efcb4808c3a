//! Commands of the program, and scenarios as text.

use std::convert::Infallible;
use std::ffi::OsString;
use std::time::Instant;

use clap::Parser;
use nereus::cli::{Arguments, Command, execute, status};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::fault::{self, InputError, detached, guarded, interruptible};

/// Runs the program with these arguments and returns its exit code: `python -m nereus`.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    detached(
        py,
        |never: Infallible| match never {},
        || Ok(status(std::iter::once(OsString::from("nereus")).chain(arguments))),
    )
}

/// Carries out a command and returns what it prints. `text` is the scenario where it has no file.
#[pyfunction]
#[pyo3(signature = (arguments, text=None))]
pub(crate) fn command<'py>(
    py: Python<'py>,
    arguments: Vec<OsString>,
    text: Option<String>,
) -> PyResult<Bound<'py, PyBytes>> {
    let begun = Instant::now();
    let words = std::iter::once(OsString::from("nereus")).chain(arguments);
    let mut parsed =
        Arguments::try_parse_from(words).map_err(|error| InputError::new_err(error.to_string()))?;
    if let Command::Bench(of) = &mut parsed.command {
        of.measured.scenario.text = text;
    }
    let out = interruptible(py, fault::command, move || {
        let mut out = Vec::new();
        execute(&parsed, begun, &mut out).map(|()| out)
    })?;
    Ok(PyBytes::new(py, &out))
}

fn toml_of(json: &str) -> PyResult<::toml::Value> {
    let value: serde_json::Value = serde_json::from_str(json).map_err(fault::internal)?;
    ::toml::Value::try_from(value)
        .map_err(|error| InputError::new_err(format!("no value of a scenario: {error}")))
}

/// A scenario given as JSON, as TOML.
#[pyfunction]
pub(crate) fn toml(json: &str) -> PyResult<String> {
    guarded(|| ::toml::to_string(&toml_of(json)?).map_err(|error| InputError::new_err(error.to_string())))
}

/// A value given as JSON, as TOML on one line.
#[pyfunction]
pub(crate) fn inline_toml(json: &str) -> PyResult<String> {
    guarded(|| Ok(toml_of(json)?.to_string()))
}

/// Panics: for the test that shows what becomes of it.
#[pyfunction]
pub(crate) fn _panic(py: Python<'_>) -> PyResult<()> {
    detached(py, |never: Infallible| match never {}, || -> Result<(), Infallible> { panic!("on purpose") })
}
