//! Scatterer paths of one emission: of targets, of the direct path, and of facets.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex64;

use super::emission::Emission;
use super::facets::Reception;
use super::sea::SeaWork;
use super::{PairPlan, PathGenerator, Workspace};
use crate::frames::{Earth, Enu, Point, Vector};
use crate::geometry::bistatic::Basis;
use crate::geometry::horizon;
use crate::geometry::light_time::Path;
use crate::paths::list::ScattererPaths;
use crate::paths::multipath::Bounce;
use crate::pulse::Pulse;
use crate::pulse::costs::{Costs, Stage};
use crate::radar::fault::RadarError;
use crate::radar::polarisation::field;
use crate::radar::window::Window;
use crate::scattering::tilt::ScatterMatrix;
use crate::scene::radar::Polarisation;
use crate::units::SPEED_OF_LIGHT_MPS;

impl PathGenerator {
    /// Appends all that the windows of pulse `index` receive, whose own emission is at hand; returns whether
    /// an echo of that lies partly or wholly outside.
    pub(super) fn append_all(
        &self,
        index: u64,
        windows: &[Window],
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<bool, RadarError> {
        let in_window =
            self.emissions_in_window(index, &workspace.own, &Window::hull(windows.iter().copied()))?;
        workspace.costs.lap(Stage::Record);
        self.append_others(index, in_window.start..in_window.end.min(index), windows, workspace, paths)?;
        let Workspace { own, other, amplitude, ships, sea, far, costs, places, .. } = &mut *workspace;
        let reception = self.reception(index, index, own, windows);
        let outside = self.append(&reception, amplitude, paths)
            || self.ships_reach_outside(index, &reception, ships)?;
        self.append_ships(index, &reception, (ships, amplitude), paths)?;
        if in_window.contains(&index) {
            self.append_sea(index, &reception, sea, (&mut *amplitude, &mut *costs), paths)?;
        }
        self.append_rain(index, &reception, (other, places, amplitude), paths)?;
        self.append_far_sea((index, 1), &reception, (other, places, amplitude), far, paths)?;
        self.append_others(index, in_window.start.max(index + 1)..in_window.end, windows, workspace, paths)?;
        Ok(outside)
    }

    /// The windows of a pulse by its record, in place of those in `out`.
    pub(super) fn recorded_windows(&self, record: &Pulse, out: &mut Vec<Window>) {
        out.clear();
        let starts_s = record.window_starts_s().iter();
        out.extend(starts_s.map(|start_s| Window::new(&self.radar, *start_s, self.pulse_length_s)));
    }

    /// Appends the paths of targets and the direct path of one emission; returns whether an echo lies partly
    /// or wholly outside.
    pub(super) fn append(
        &self,
        reception: &Reception,
        amplitude: &mut [Complex64],
        paths: &mut ScattererPaths,
    ) -> bool {
        let mut outside = false;
        for (point, of_pairs) in reception.emission.paths.chunks_exact(self.pairs.len().max(1)).enumerate() {
            outside |= self.weigh(reception, point, of_pairs, amplitude);
            if amplitude.iter().any(|a| *a != Complex64::ZERO) {
                let delays = of_pairs.iter().map(|path| (path.delay_s, path.delay_rate));
                paths.push(reception.offset_s, delays, amplitude);
            }
        }
        outside
    }

    /// Appends all that the window of a pulse receives of other emissions.
    pub(super) fn append_others(
        &self,
        index: u64,
        emissions: Range<u64>,
        windows: &[Window],
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        let Workspace { other, amplitude, ships, sea, costs, .. } = workspace;
        for emitted in emissions {
            self.evaluate(emitted, other)?;
            let reception = self.reception(index, emitted, other, windows);
            self.append(&reception, amplitude, paths);
            self.append_ships(emitted, &reception, (ships, amplitude), paths)?;
            self.append_sea(emitted, &reception, sea, (&mut *amplitude, &mut *costs), paths)?;
        }
        Ok(())
    }

    /// Appends the facets that one emission illuminates.
    pub(super) fn append_sea(
        &self,
        emitted: u64,
        reception: &Reception,
        work: &mut Option<SeaWork>,
        (amplitude, costs): (&mut [Complex64], &mut Costs),
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        let Some(sea) = &self.sea else { return Ok(()) };
        let Some(work) = self.sea_work(sea, work) else { return Ok(()) };
        let before = paths.len();
        let visited = sea.visit(reception, work, costs, |chunk| {
            for place in 0..chunk.index.len() {
                if chunk.amplitude.iter().all(|column| column[place] == Complex64::ZERO) {
                    continue;
                }
                paths.emission_offset_s.push(reception.offset_s);
                for (pair, columns) in chunk.pairs.iter().enumerate() {
                    paths.delay_s[pair].push(columns.delay_s[place]);
                    paths.delay_rate[pair].push(columns.delay_rate[place]);
                }
                for (column, amplitude) in paths.amplitude.iter_mut().zip(&chunk.amplitude) {
                    column.push(amplitude[place]);
                }
            }
        });
        costs.looked_at(sea.patch.len(), paths.len() - before, 0);
        visited.map_err(|failure| self.sea_error(emitted, failure))?;
        if sea.breaking.is_none() {
            return Ok(());
        }
        let mut breakers = || {
            let (patch, mix) = sea.seen(reception, work)?;
            let weight =
                |antenna: usize, facet| mix.as_ref().map_or(1.0, |mix| mix.weight(antenna, patch.key(facet)));
            self.append_breakers(sea, reception, &patch, weight, amplitude, paths)
        };
        breakers().map_err(|failure| self.sea_error(emitted, failure))
    }

    /// Amplitudes of a target (or, beyond the last one, an image, and beyond these the direct path) in every
    /// channel; returns whether an echo lies partly or wholly outside the window.
    pub(super) fn weigh(
        &self,
        reception: &Reception,
        point: usize,
        of_pairs: &[Path],
        amplitude: &mut [Complex64],
    ) -> bool {
        let Reception { emission, offset_s, tx_pol, .. } = *reception;
        let mut outside = false;
        let variation = emission.variation.get(point * self.plans.len()..).unwrap_or_default();
        let image = point.checked_sub(self.targets.len()).filter(|image| *image < self.images.len());
        let of_target = image.map_or(point, |image| self.images[image].target);
        let target = self.targets.get(of_target);
        amplitude.fill(Complex64::ZERO);
        for (pair, (plan, path)) in self.plans.iter().zip(of_pairs).enumerate() {
            let range = |leg_s: f64| leg_s * SPEED_OF_LIGHT_MPS;
            let scale = match target {
                Some(_) => plan.link.scattered(range(path.tx_leg_s), range(path.rx_leg_s)),
                None => plan.link.direct(range(path.delay_s)),
            };
            // What hides a target hides its image.
            let straight = image.map_or(path, |_| &emission.paths[of_target * self.plans.len() + pair]);
            let mut scale = scale * self.passes_horizon(plan, emission, straight, target.is_none());
            if let Some(variation) = variation.get(pair) {
                scale *= variation;
            }
            if scale == 0.0 || !plan.receives(tx_pol) {
                continue;
            }
            let (begin_s, window) = (offset_s + path.delay_s, reception.window(plan));
            outside |= !window.holds(begin_s);
            if window.touches(begin_s) {
                let bounce = image.map(|image| &emission.bounces[image * self.plans.len() + pair]);
                let matrix = target.map(|target| &target.scattering);
                self.amplitudes(plan, (path, bounce), matrix, scale, tx_pol, emission, amplitude);
            }
        }
        outside
    }

    /// Share of the field of a path that passes the horizons of its antennas.
    pub(super) fn passes_horizon(
        &self,
        plan: &PairPlan,
        emission: &Emission,
        path: &Path,
        direct: bool,
    ) -> f64 {
        let earth = self.frame.hiding_earth();
        if earth == Earth::Flat {
            return 1.0;
        }
        let on = |from: Point<Enu>, along: DVec3, leg_s: f64| {
            Point::from_raw(from.raw() + along * (leg_s * SPEED_OF_LIGHT_MPS))
        };
        let tx = emission.centres[plan.pair.transmitter].position;
        if direct {
            return seen(earth, tx, on(tx, path.incident, path.delay_s));
        }
        let at = on(tx, path.incident, path.tx_leg_s);
        seen(earth, tx, at) * seen(earth, on(at, path.scattered, path.rx_leg_s), at)
    }

    /// The same of what a ship returns, from where a wave meets it and leaves it: a path with two bounces
    /// goes by an image, where no wave is.
    pub(super) fn passes_horizon_of_ship(
        &self,
        plan: &PairPlan,
        emission: &Emission,
        [meets, leaves]: [Point<Enu>; 2],
    ) -> f64 {
        let earth = self.frame.hiding_earth();
        let centre = |antenna: usize| emission.centres[antenna].position;
        let rx = self.radar.transmitters.len() + plan.pair.receiver;
        seen(earth, centre(plan.pair.transmitter), meets) * seen(earth, centre(rx), leaves)
    }

    /// Amplitudes of one path in the channels of its pair, with what the sea did to it; `matrix` is `None`
    /// for the direct path.
    pub(super) fn amplitudes(
        &self,
        plan: &PairPlan,
        (path, bounce): (&Path, Option<&Bounce>),
        matrix: Option<&ScatterMatrix>,
        scale: f64,
        tx_pol: Option<Polarisation>,
        emission: &Emission,
        amplitude: &mut [Complex64],
    ) {
        let directions = bounce.map_or([path.incident, path.scattered], |bounce| bounce.at_antennas);
        let gains = self.gains_towards(plan, directions, path.delay_s, emission) * scale;
        if gains != Complex64::ZERO {
            self.polarised(plan, (path, bounce), matrix, gains, tx_pol, emission, amplitude);
        }
    }

    /// Product of the field gains of both antennas of a pair, given the directions in which a path leaves the
    /// transmitter and arrives at the receiver, and its delay.
    pub(super) fn gains_towards(
        &self,
        plan: &PairPlan,
        [sent, received]: [DVec3; 2],
        delay_s: f64,
        emission: &Emission,
    ) -> Complex64 {
        let tx = plan.pair.transmitter;
        let rx = self.radar.transmitters.len() + plan.pair.receiver;
        let tx_axes = emission.axes(tx);
        let rx_axes = emission.axes_after(rx, delay_s, self.axes_span_s);
        let gain = |antenna: usize, axes: &glam::DMat3, d: DVec3| {
            self.antennas[antenna].field_gain(Vector::from_raw(axes.transpose() * d))
        };
        gain(tx, &tx_axes, sent) * gain(rx, &rx_axes, -received)
    }

    /// Amplitudes of a path between antennas of given gains.
    pub(super) fn polarised(
        &self,
        plan: &PairPlan,
        (path, bounce): (&Path, Option<&Bounce>),
        matrix: Option<&ScatterMatrix>,
        gains: Complex64,
        tx_pol: Option<Polarisation>,
        emission: &Emission,
        amplitude: &mut [Complex64],
    ) {
        let tx = plan.pair.transmitter;
        let rx = self.radar.transmitters.len() + plan.pair.receiver;
        let [sent, received] = bounce.map_or([path.incident, path.scattered], |bounce| bounce.at_antennas);
        let (basis_in, basis_out) = (Basis::of(sent), Basis::of(received));
        let tx_errors = self.radar.transmitters[tx].antenna.ports;
        let rx_errors = self.radar.receivers[plan.pair.receiver].antenna.ports;
        let tx_basis = emission.basis(tx);
        let rx_basis = emission.basis_after(rx, path.delay_s, self.axes_span_s);
        for &(channel, tx_port, rx_port) in &plan.channels {
            if tx_pol.is_some_and(|port| port != tx_port) {
                continue;
            }
            let mut e_t = field(&tx_basis, tx_port, tx_errors, sent, &basis_in);
            let mut e_r = field(&rx_basis, rx_port, rx_errors, -received, &basis_out);
            if let Some(Bounce { leaves: [of_sent, of_received], .. }) = bounce {
                e_t = [e_t[0] * of_sent[0], e_t[1] * of_sent[1]];
                e_r = [e_r[0] * of_received[0], e_r[1] * of_received[1]];
            }
            let returned = match matrix {
                None => e_r[0] * e_t[0] + e_r[1] * e_t[1],
                Some(s) => {
                    e_r[0] * (s[0][0] * e_t[0] + s[0][1] * e_t[1])
                        + e_r[1] * (s[1][0] * e_t[0] + s[1][1] * e_t[1])
                }
            };
            let rain = match matrix {
                Some(_) => plan.link.in_rain_over([tx_port, rx_port], path),
                None => plan.link.in_rain_direct([tx_port, rx_port], path),
            };
            amplitude[channel] = gains * returned * rain;
        }
    }
}

fn seen(earth: Earth, from: Point<Enu>, to: Point<Enu>) -> f64 {
    horizon::weight(horizon::clearance_m(earth, from, to), horizon::POINT_EDGE_M)
}
