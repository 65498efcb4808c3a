//! Single forged datagrams: what they cost a reception.

use nereus::pulse::SampleFormat;
use nereus::receive::Receiver;

use crate::wire_hostile::{DESCRIPTIONS, later, near, received, states, wide};

/// Before: the pulse that such a state opened took the middle packets of the true one, of which none was whole.
#[test]
fn a_state_one_sample_early_costs_no_pulse() {
    let header = wide(SampleFormat::Ci16);
    let all = near(&header, 100);
    let per_pulse = (all.len() - DESCRIPTIONS) / 100;
    let mut mixed = all[..DESCRIPTIONS].to_vec();
    for pulse in all[DESCRIPTIONS..].chunks(per_pulse) {
        mixed.extend(states(pulse).next().map(|state| later(state, -1.0 / header.sample_rate_hz)));
        mixed.extend_from_slice(pulse);
    }
    let (indices, report) = received(Receiver::new(), &mixed);
    assert_eq!(indices, (0..100).collect::<Vec<_>>(), "{report:?}");
    assert_eq!((report.implausible, report.misnumbered, report.missing.pulses_by_index), (0, 0, 0));
}
