//! All pulses of a run in memory, as they are released.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crossbeam_channel::Sender;
use num_complex::Complex32;

use super::speed::SpeedError;
use crate::pipeline::build::PulseStream;
use crate::pulse::{Pulse, Samples};
use crate::transport::pacer::Status;

/// The pulses of a run without converter.
pub struct Gathered {
    /// Emission of each pulse, s after that of the first.
    pub emission_s: Vec<f64>,
    /// First sample after the emission, s.
    pub window_start_s: Vec<f64>,
    /// What was radiated, see [`Pulse::tx_pol`].
    pub tx_pol: Vec<u8>,
    /// True phase centres, ENU metres, `[pulse][transmitters, then receivers]`.
    pub phase_centre_m: Vec<Vec<[f64; 3]>>,
    /// IQ, `[pulse][channel x sample]`, sqrt(W).
    pub samples: Vec<Vec<Complex32>>,
}

/// Runs a stream to its end and keeps what it releases. Give it a run without sinks and converter, at pace
/// `fast`: nothing is lost then.
///
/// # Errors
/// A run that cannot be started, or fails.
pub fn gather(stream: PulseStream, status: Option<Sender<Status>>) -> Result<Gathered, SpeedError> {
    let mut held = Gathered {
        emission_s: Vec::new(),
        window_start_s: Vec::new(),
        tx_pol: Vec::new(),
        phase_centre_m: Vec::new(),
        samples: Vec::new(),
    };
    let mut first = None;
    let see = |pulse: &Pulse| {
        let begin = *first.get_or_insert(pulse.time);
        held.emission_s.push(pulse.time.since(begin));
        held.window_start_s.push(pulse.window_start_s);
        held.tx_pol.push(pulse.tx_pol);
        held.phase_centre_m.push(pulse.antennas.iter().map(|antenna| antenna.phase_centre_m).collect());
        held.samples.push(match &pulse.samples {
            Samples::Cf32(samples) => samples.clone(),
            Samples::Ci16(codes) => {
                codes.iter().map(|[re, im]| Complex32::new(f32::from(*re), f32::from(*im))).collect()
            }
        });
    };
    let (outcome, _) = stream.measure(&Arc::new(AtomicBool::new(false)), status, see)?;
    outcome.result.map_err(|error| SpeedError::Run(Box::new(error)))?;
    Ok(held)
}
