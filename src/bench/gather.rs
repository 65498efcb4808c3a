//! All pulses of a run in memory, as they are released.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crossbeam_channel::Sender;

use super::speed::SpeedError;
use crate::pipeline::build::PulseStream;
use crate::pulse::Pulse;
use crate::pulse::gathered::Gathered;
use crate::transport::pacer::Status;

/// Runs a stream to its end and keeps what it releases. Give it a run without sinks and converter, at pace
/// `fast`: nothing is lost then.
///
/// # Errors
/// A run that cannot be started, or fails.
pub fn gather(stream: PulseStream, status: Option<Sender<Status>>) -> Result<Gathered, SpeedError> {
    let mut gathered = Gathered::default();
    let see = |pulse: &Pulse| gathered.push(pulse);
    let (outcome, _) = stream.measure(&Arc::new(AtomicBool::new(false)), status, see)?;
    outcome.result.map_err(|error| SpeedError::Run(Box::new(error)))?;
    Ok(gathered)
}
