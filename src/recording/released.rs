//! Pulses of a recording as they were released.

use super::{RECEIVER_WINDOWS, Recording};
use crate::pulse::{Layout, PlatformRecord, Pulse, SampleFormat, Samples};
use crate::time::TimeTag;

const NANOSECONDS: i64 = 1_000_000_000;

impl Recording {
    /// Sizes of the pulses that [`Self::pulse`] fills: samples are in sqrt(W), codes too.
    pub fn layout(&self) -> Layout {
        Layout { format: SampleFormat::Cf32, ..self.header.layout }
    }

    /// Fills a slot with a pulse in use. What was not recorded is not a number; channels that were not read
    /// are zero.
    pub fn pulse(&self, pulse: usize, slot: &mut Pulse) {
        let (Some(row), Some(index)) = (self.rows.clone().nth(pulse), self.index.get(pulse)) else { return };
        slot.index = *index;
        let zero = TimeTag::new(
            self.zero_ns.div_euclid(NANOSECONDS),
            self.zero_ns.rem_euclid(NANOSECONDS) as f64 * 1e-9,
        );
        slot.time = zero.plus(self.path_s[row]);
        slot.window_start_s = self.window_start_s[pulse];
        self.fill(RECEIVER_WINDOWS, row, &mut slot.receiver_window_start_s);
        slot.tx_pol = self.tx_pol[pulse];
        slot.flags = self.flag("pulse/flags", row);
        slot.nav_arrived = None;
        if let Samples::Cf32(samples) = &mut slot.samples {
            let length = self.header.layout.samples;
            for (channel, to) in samples.chunks_exact_mut(length.max(1)).enumerate() {
                match self.window(pulse, channel) {
                    [] => to.fill(Default::default()),
                    from => to.copy_from_slice(from),
                }
            }
        }
        for (place, name) in self.header.platforms.iter().enumerate() {
            for (kind, records) in [("true", &mut slot.nav_true), ("reported", &mut slot.nav_reported)] {
                let at = |what: &str| format!("nav/{name}/{kind}/{what}");
                let Some(record) = records.get_mut(place) else { continue };
                *record = PlatformRecord {
                    position_m: self.values(&at("position_m"), row),
                    velocity_mps: self.values(&at("velocity_mps"), row),
                    attitude_quat: self.values(&at("attitude_quat"), row),
                    age_s: self.values::<1>(&at("age_s"), row)[0],
                    flags: self.flag(&at("flags"), row),
                };
            }
        }
        for (number, name) in self.header.antennas().enumerate() {
            let Some(antenna) = slot.antennas.get_mut(number) else { continue };
            let at = |what: &str| format!("nav/{name}/{what}");
            antenna.phase_centre_m = self.values(&at("phase_centre_m"), row);
            antenna.boresight_quat = self.values(&at("boresight_quat"), row);
            antenna.reported_phase_centre_m = self.values(&at("reported_phase_centre_m"), row);
            antenna.encoder_deg = self.header.scans(number).then(|| self.values(&at("encoder_deg"), row));
        }
        self.fill("truth/delay_s", row, &mut slot.target_delay_s);
        self.fill("truth/doppler_hz", row, &mut slot.target_doppler_hz);
        self.fill("truth/ship_position_m", row, slot.ship_position_m.as_flattened_mut());
        self.fill("truth/ship_velocity_mps", row, slot.ship_velocity_mps.as_flattened_mut());
        self.fill("truth/ship_heading_deg", row, &mut slot.ship_heading_deg);
        for (clock, name) in slot.clock_x_s.iter_mut().zip(&self.header.clocks) {
            *clock = self.values::<1>(&format!("truth/clock/{name}/x_s"), row)[0];
        }
    }

    fn flag(&self, column: &str, row: usize) -> u32 {
        self.flags.get(column).and_then(|flags| flags.get(row)).copied().unwrap_or(0)
    }

    fn fill(&self, column: &str, row: usize, to: &mut [f64]) {
        let width = to.len();
        let known = self.numbers.get(column).filter(|(wide, _)| *wide == width);
        match known.and_then(|(_, values)| values.get(row * width..(row + 1) * width)) {
            Some(values) => to.copy_from_slice(values),
            None => to.fill(f64::NAN),
        }
    }

    fn values<const N: usize>(&self, column: &str, row: usize) -> [f64; N] {
        let mut values = [f64::NAN; N];
        self.fill(column, row, &mut values);
        values
    }
}
