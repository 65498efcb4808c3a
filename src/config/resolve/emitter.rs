//! What radiates besides.

use super::antenna::{self, MountKeys, mount_keys};
use super::signal::{emissions, waveform as waveform_of};
use super::{Ground, Names};
use crate::config::error::Problem;
use crate::config::keys;
use crate::config::section::Section;
use crate::scene::Emitter;
use crate::scene::radar::{Band, Transmitter, Waveform};

/// Names that emitters refer to, or may not have.
pub(super) struct Known<'n> {
    pub(super) transmitters: &'n Names,
    pub(super) receivers: &'n Names,
    pub(super) platforms: &'n Names,
}

/// `[[emitter]]`, for a radar of this carrier and sample rate.
pub(super) fn emitters(
    root: &Section<'_>,
    ground: &Ground,
    known: &Known<'_>,
    radar: (Option<f64>, Option<f64>),
) -> Option<Vec<Emitter>> {
    let mut names = Names::new("emitter");
    let sections = root.sections(&keys::root::EMITTER);
    let found: Vec<Option<Emitter>> = sections
        .into_iter()
        .zip(1..)
        .map(|(section, number)| {
            names.take(&section, &keys::emitter::NAME, &[known.transmitters, known.receivers]);
            emitter((section, number), names.last(), ground, known, radar)
        })
        .collect();
    found.into_iter().collect()
}

fn emitter(
    (section, number): (Section<'_>, u64),
    name: Option<String>,
    ground: &Ground,
    known: &Known<'_>,
    (of_radar_hz, sample_rate_hz): (Option<f64>, Option<f64>),
) -> Option<Emitter> {
    use keys::emitter as k;
    let power_w = section.number(&k::POWER_W);
    let antenna = antenna::mount(&section, &mount_keys!(emitter), ground, known.platforms);
    let own_hz = section.number(&k::CARRIER_HZ);
    let carrier_hz = if section.has(&k::CARRIER_HZ) { own_hz } else { of_radar_hz };
    let emissions = emissions(&section, [&k::PRF_HZ, &k::PRI_US]);
    let start_us = section.number(&k::START_US);
    let waveform = section.section(&k::WAVEFORM);
    let waveform = waveform.and_then(|section| waveform_of(section, None, (emissions.as_ref(), number)));
    let polarisation = section.choice(&k::POLARISATION);
    let receivers = known.receivers.find_all(&section, &k::HEARD_BY);
    let (direct_path, echo) = (section.flag(&k::DIRECT_PATH), section.flag(&k::ECHO));
    let bands = (carrier_hz.zip(of_radar_hz), waveform.as_ref().zip(sample_rate_hz));
    if let (Some((own_hz, radar_hz)), Some((waveform, sample_rate_hz))) = bands {
        let reaches_hz = match waveform.level() {
            Waveform::Samples { rate_hz, .. } => 0.5 * rate_hz,
            // Of what a file has it is not known yet.
            other => other.band().map_or(f64::INFINITY, Band::reach_hz),
        };
        let (begins_hz, half_hz) = ((own_hz - radar_hz).abs() - reaches_hz, 0.5 * sample_rate_hz);
        if begins_hz >= half_hz {
            section.fault(&k::CARRIER_HZ, Problem::OutOfBand { begins_hz, half_hz });
        }
    }
    section.finish();
    Some(Emitter {
        transmitter: Transmitter { name: name?, power_w: power_w?, antenna: antenna? },
        carrier_hz: carrier_hz?,
        waveform: waveform?,
        emissions: emissions?.starting(start_us? / 1e6),
        polarisation: polarisation?,
        receivers: receivers?,
        direct_path: direct_path?,
        echo: echo?,
    })
}
