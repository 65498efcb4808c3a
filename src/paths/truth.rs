//! What a pulse records in addition to its samples: navigation, antennas, truth, and where its window opens.

use std::time::Instant;

use glam::{DMat3, DQuat};

use super::{PathGenerator, beside};
use crate::geometry::light_time::{LightTime, bistatic};
use crate::motion::pointing::PhaseCentre;
use crate::motion::scan;
use crate::motion::track::State;
use crate::paths::emission::{Emission, TrackFailure};
use crate::pulse::{PlatformRecord, Pulse};
use crate::radar::fault::{RadarError, TrackUse, mounts};
use crate::radar::window::Window;
use crate::scene::radar::{AntennaMount, Gate, Pointing, Polarisation, Scan};
use crate::time::TimeTag;

impl PathGenerator {
    pub(super) fn fill_record(
        &self,
        index: u64,
        own: &Emission,
        record: &mut Pulse,
    ) -> Result<(), RadarError> {
        let t = self.pulse_time(index);
        record.index = index;
        record.time = t;
        record.flags = 0;
        // A block of samples receives emissions of any.
        let tx_pol = self.radar.tx_polarisation.of_pulse(index).filter(|_| !self.is_apart());
        record.tx_pol = tx_pol.map_or(0, Polarisation::code);
        record.nav_arrived = None;
        for ((slot, state), tracks) in record.nav_true.iter_mut().zip(&own.states).zip(&self.tracks) {
            *slot = navigation(state);
            if let Some(live) = tracks.truth.as_live() {
                let reported = live.report(t);
                (slot.age_s, slot.flags) = (reported.age_s, reported.flags);
                record.flags |= reported.flags;
                let earlier =
                    |before: Instant| reported.arrived.map_or(before, |arrived| arrived.min(before));
                record.nav_arrived =
                    record.nav_arrived.map_or(reported.arrived, |before| Some(earlier(before)));
            }
        }
        for (platform, slot) in record.nav_reported.iter_mut().enumerate().take(self.tracks.len()) {
            let which = TrackUse::Reported;
            let report = self.tracks[platform].reported.report(t);
            let report =
                report.map_err(|source| self.track_error(index, TrackFailure { platform, which, source }))?;
            *slot = PlatformRecord { age_s: report.age_s, flags: report.flags, ..navigation(&report.state) };
            record.flags |= report.flags;
            for (antenna, (_, mount)) in record.antennas.iter_mut().zip(mounts(&self.radar)) {
                if mount.platform == platform {
                    let centre = PhaseCentre::of(&report.state, mount.lever_arm);
                    antenna.reported_phase_centre_m = centre.position.to_array();
                }
            }
        }
        for (antenna, (slot, centre)) in record.antennas.iter_mut().zip(&own.centres).enumerate() {
            slot.phase_centre_m = centre.position.to_array();
            slot.boresight_quat = quaternion(&own.axes(antenna));
        }
        for (antenna, (slot, (_, mount))) in record.antennas.iter_mut().zip(mounts(&self.radar)).enumerate() {
            let Pointing::Scan(Scan { law, encoder, .. }) = &mount.pointing else { continue };
            let points = scan::direction(law, t.since(self.start));
            slot.encoder_deg = Some(scan::reading_deg(encoder, points, self.seed, (index, antenna)));
        }
        let (pairs, targets) = (self.pairs.len(), self.targets.len());
        for pair in 0..pairs {
            let delays = record.target_delay_s.iter_mut().skip(pair * targets);
            let dopplers = record.target_doppler_hz.iter_mut().skip(pair * targets);
            for (target, (delay_s, doppler_hz)) in delays.zip(dopplers).take(targets).enumerate() {
                let path = &own.paths[target * pairs + pair];
                *delay_s = path.delay_s;
                *doppler_hz = path.doppler_hz(self.radar.carrier_hz);
            }
        }
        if let Some(clocks) = &self.clocks {
            for (clock, x_s) in record.clock_x_s.iter_mut().enumerate() {
                *x_s = clocks.reading(clock, index)[0];
            }
        }
        for (window, start_s) in record.receiver_window_start_s.iter_mut().enumerate() {
            *start_s = self.window_start_s(window, index, t)?;
        }
        record.window_start_s = self.window_start_s(self.first_window(), index, t)?;
        Ok(())
    }

    /// Start of a window after the emission at `t`, s: earlier than nominal by what the clocks are wrong.
    pub(super) fn window_start_s(&self, window: usize, index: u64, t: TimeTag) -> Result<f64, RadarError> {
        let nominal_s = self.nominal_start_s(window, index, t)?;
        let Some(clocks) = &self.clocks else { return Ok(nominal_s) };
        Ok(nominal_s - clocks.window_shift_s(window, index, nominal_s))
    }

    /// The same by the clocks of the radar: what is recorded.
    pub(super) fn nominal_start_s(&self, window: usize, index: u64, t: TimeTag) -> Result<f64, RadarError> {
        let lead = self.leads.get(window);
        let gate = lead.map_or(&self.radar.window.gate, |lead| self.radar.gate(lead.receiver));
        let (aim, lead_s, aim_from) = match gate {
            Gate::Fixed { start_s } => return Ok(*start_s),
            Gate::Follow { aim, lead_s, aim_from } => (aim, *lead_s, *aim_from),
        };
        let Some(pair) = lead else { return Ok(-lead_s) };
        let failed = |platform| {
            move |source| self.track_error(index, TrackFailure { platform, which: aim_from.into(), source })
        };
        let end = |mount: &AntennaMount| {
            let state =
                self.tracks[mount.platform].known(aim_from).state(t).map_err(failed(mount.platform))?;
            Ok(PhaseCentre::of(&state, mount.lever_arm))
        };
        let tx = end(&self.radar.transmitters[pair.transmitter].antenna)?;
        let rx = end(&self.radar.receivers[pair.receiver].antenna)?;
        let beside = beside(aim).unwrap_or(0);
        let (position, velocity) = self.surroundings().aim_point(aim, aim_from, t).map_err(failed(beside))?;
        Ok(bistatic(LightTime::Exact, &tx, position, velocity, &rx).delay_s - lead_s)
    }

    /// How many windows there are: one for all receivers, or one for each.
    pub fn windows(&self) -> usize {
        self.leads.len().max(1)
    }

    /// The window of each pair.
    pub fn pair_windows(&self) -> Vec<usize> {
        self.plans.iter().map(|plan| plan.window).collect()
    }

    /// That of the first pair.
    fn first_window(&self) -> usize {
        self.plans.first().map_or(0, |plan| plan.window)
    }

    /// All windows of a pulse, as they are, in place of those in `out`.
    pub(super) fn windows_at(&self, index: u64, out: &mut Vec<Window>) -> Result<(), RadarError> {
        let t = self.radar.emissions.emission(self.start, index);
        out.clear();
        for window in 0..self.windows() {
            out.push(self.window_at(window, index, t)?);
        }
        Ok(())
    }

    /// A window of the pulse emitted at `t`, as it is.
    fn window_at(&self, window: usize, index: u64, t: TimeTag) -> Result<Window, RadarError> {
        Ok(Window::new(&self.radar, self.window_start_s(window, index, t)?, self.pulse_length_s))
    }

    /// What lies between the first start and the last end of them.
    pub(super) fn hull_at(&self, index: u64) -> Result<Window, RadarError> {
        let t = self.radar.emissions.emission(self.start, index);
        let first = self.window_at(0, index, t)?;
        (1..self.windows())
            .try_fold(first, |hull, window| Ok(hull.hull_with(self.window_at(window, index, t)?)))
    }

    /// Writes into a record when its windows open by the clocks of the radar, in place of when they do.
    ///
    /// # Errors
    /// A receive window that follows a platform whose track does not cover the pulse.
    pub fn record_nominal(&self, record: &mut Pulse) -> Result<(), RadarError> {
        let (index, t) = (record.index, record.time);
        for (window, start_s) in record.receiver_window_start_s.iter_mut().enumerate() {
            *start_s = self.nominal_start_s(window, index, t)?;
        }
        record.window_start_s = self.nominal_start_s(self.first_window(), index, t)?;
        Ok(())
    }
}

fn navigation(state: &State) -> PlatformRecord {
    PlatformRecord {
        position_m: state.position.to_array(),
        velocity_mps: state.velocity.to_array(),
        attitude_quat: state.attitude.to_wxyz(),
        ..PlatformRecord::default()
    }
}

/// Axes as a quaternion, scalar first and not negative.
fn quaternion(axes: &DMat3) -> [f64; 4] {
    let q = DQuat::from_mat3(axes);
    let q = if q.w < 0.0 { -q } else { q };
    [q.w, q.x, q.y, q.z]
}
