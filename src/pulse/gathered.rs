//! All pulses of a run in memory, as they are released.

use num_complex::Complex32;

use super::{Pulse, Samples};
use crate::time::TimeTag;

/// The pulses of a run without converter.
#[derive(Clone, Debug, Default)]
pub struct Gathered {
    /// Numbers of the pulses.
    pub numbers: Vec<u64>,
    /// Emission of each pulse, s after that of the first.
    pub emission_s: Vec<f64>,
    /// First sample after the emission, s: one for all receivers, or one for each.
    pub window_starts_s: Vec<Vec<f64>>,
    /// What was radiated, see [`Pulse::tx_pol`].
    pub tx_pol: Vec<u8>,
    /// True phase centres, ENU metres, `[pulse][transmitters, then receivers]`.
    pub phase_centre_m: Vec<Vec<[f64; 3]>>,
    /// IQ, `[pulse][channel x sample]`, sqrt(W).
    pub samples: Vec<Vec<Complex32>>,
    first: Option<TimeTag>,
}

impl Gathered {
    /// Keeps the next pulse.
    pub fn push(&mut self, pulse: &Pulse) {
        let begin = *self.first.get_or_insert(pulse.time);
        self.numbers.push(pulse.index);
        self.emission_s.push(pulse.time.since(begin));
        self.window_starts_s.push(pulse.window_starts_s().to_vec());
        self.tx_pol.push(pulse.tx_pol);
        self.phase_centre_m.push(pulse.antennas.iter().map(|antenna| antenna.phase_centre_m).collect());
        self.samples.push(match &pulse.samples {
            Samples::Cf32(samples) => samples.clone(),
            Samples::Ci16(codes) => {
                codes.iter().map(|[re, im]| Complex32::new(f32::from(*re), f32::from(*im))).collect()
            }
        });
    }
}
