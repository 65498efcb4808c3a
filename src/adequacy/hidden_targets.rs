//! Targets that the curve of the earth hides.

use crate::pipeline::build::PulseStream;
use crate::radar::fault::RadarError;

/// Targets and antennas that are named one by one.
const MOST_NAMED: usize = 8;

/// Targets that the earth hides at the first, middle or last pulse: each once for each antenna.
///
/// # Errors
/// Tracks that do not cover a pulse.
pub fn warnings(stream: &PulseStream) -> Result<Vec<String>, RadarError> {
    let schedule = stream.schedule();
    let mut known: Vec<(String, String)> = Vec::new();
    let mut warnings = Vec::new();
    for index in [schedule.first, schedule.first + schedule.count / 2, schedule.end().saturating_sub(1)] {
        for of in stream.factory().beyond_horizon(index)? {
            let both = (of.target, of.antenna);
            if known.contains(&both) {
                continue;
            }
            if known.len() < MOST_NAMED {
                warnings.push(format!(
                    "target \"{}\" lies beyond the horizon of \"{}\" at pulse {}: {:.1} km away, seen to {:.1} km",
                    both.0,
                    both.1,
                    of.pulse,
                    of.distance_m / 1e3,
                    of.horizon_m / 1e3
                ));
            }
            known.push(both);
        }
    }
    if known.len() > MOST_NAMED {
        warnings.push(format!("{} more targets and antennas beyond the horizon", known.len() - MOST_NAMED));
    }
    Ok(warnings)
}
