//! Faults as exceptions, with the texts of the command line.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;
use std::time::Duration;

use nereus::ScenarioError as Fault;
use nereus::cli::CliError;
use nereus::config::ConfigError;
use nereus::pipeline::fault::BuildErrors;
use pyo3::import_exception;
use pyo3::prelude::*;

import_exception!(nereus.errors, InputError);
import_exception!(nereus.errors, InternalError);
import_exception!(nereus.errors, RunError);
import_exception!(nereus.errors, ScenarioError);
import_exception!(nereus.errors, StreamClosed);

/// Does some work; a panic, which is a fault of the program, becomes an exception as well.
pub(crate) fn guarded<T>(work: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(internal(message_of(panic.as_ref()))))
}

/// The same without the GIL: for work that takes long and touches nothing of Python.
pub(crate) fn detached<T: Send, E: Send>(
    py: Python<'_>,
    raise: impl FnOnce(E) -> PyErr,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)).map_err(|panic| message_of(panic.as_ref())));
    match done {
        Ok(done) => done.map_err(raise),
        Err(panic) => Err(internal(panic)),
    }
}

/// The same in a thread of its own, so that Ctrl-C is an exception at once. The work goes on unseen to its
/// end: it has nothing that could stop it.
pub(crate) fn interruptible<T: Send + 'static, E: Send + 'static>(
    py: Python<'_>,
    raise: impl FnOnce(E) -> PyErr,
    work: impl FnOnce() -> Result<T, E> + Send + 'static,
) -> PyResult<T> {
    let thread = thread::Builder::new().name("command".to_owned()).spawn(work).map_err(internal)?;
    while !thread.is_finished() {
        py.check_signals()?;
        py.detach(|| thread::sleep(Duration::from_millis(5)));
    }
    thread.join().map_err(|panic| internal(message_of(panic.as_ref())))?.map_err(raise)
}

fn message_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a panic".to_owned())
}

/// A fault of the program.
pub(crate) fn internal(what: impl ToString) -> PyErr {
    InternalError::new_err(format!("a fault of the program: {}; please report it", what.to_string()))
}

fn config(error: &ConfigError) -> PyErr {
    let faults: Vec<String> = error.faults().iter().map(ToString::to_string).collect();
    ScenarioError::new_err((error.to_string(), faults))
}

fn build(error: &BuildErrors) -> PyErr {
    let faults: Vec<String> = error.0.iter().map(ToString::to_string).collect();
    ScenarioError::new_err((error.to_string(), faults))
}

/// Why a scenario gives no pulses.
pub(crate) fn scenario(error: Fault) -> PyErr {
    match &error {
        Fault::Config(error) => config(error),
        Fault::Build(error) => build(error),
        Fault::Run(error) => match **error {
            nereus::pipeline::build::RunFailure::Panic { .. } => internal(error),
            _ => RunError::new_err(error.to_string()),
        },
    }
}

/// Why a command ends early.
pub(crate) fn command(error: CliError) -> PyErr {
    match &error {
        CliError::Config(error) => config(error),
        CliError::Build(error) => build(error),
        error if error.exit_code() == 2 => InputError::new_err(error.to_string()),
        error => RunError::new_err(error.to_string()),
    }
}
