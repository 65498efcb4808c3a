//! Antennas of random scenes, more transmitters and receivers, and emitters beside.

use std::fmt::Write as _;

use rand::Rng;

use super::random_scene::{Draw, Flight, Geometry, LIGHT_MPS, Signal, line};
use super::random_waveforms::{endless, waveform};

const LOOKS: &str = "antenna = { kind = \"isotropic\", gain_dbi = 12.0 }\npointing = { kind = \"at\", position_m = [0.0, 0.0, 0.0] }";

fn platform(name: &str, flight: Flight, out: &mut String) {
    line!(out, "[[platform]]\nname = \"{name}\"");
    let Flight { position_m, velocity_mps } = flight;
    match velocity_mps == [0.0; 3] {
        true => line!(out, "track = {{ kind = \"fixed\", position_m = {position_m:?} }}"),
        false => line!(
            out,
            "track = {{ kind = \"straight\", position_m = {position_m:?}, velocity_mps = {velocity_mps:?} }}"
        ),
    }
}

/// Now and then tapers of an aperture.
fn tapers(draw: &mut Draw) -> String {
    let one = |draw: &mut Draw| draw.one(&["uniform", "cosine", "hamming", "taylor"]);
    if !draw.chance(0.25) {
        return String::new();
    }
    format!(", taper = \"{}\", height_taper = \"{}\"", one(draw), one(draw))
}

/// A pedestal whose beam passes over the patch, once or again and again; none of an orbit.
fn scanning(draw: &mut Draw, geometry: &Geometry, flight: &Flight) -> Option<String> {
    let [x, y, z] = flight.position_m;
    let level_m = x.hypot(y);
    let (bearing_deg, elevation_deg) = ((-x).atan2(-y).to_degrees(), -z.atan2(level_m).to_degrees());
    let across_deg = (geometry.size_m[0].max(geometry.size_m[1]) / level_m).atan().to_degrees();
    let lasts_s = geometry.lasts_s;
    let (sense, share, turns) = (draw.one(&[-1.0, 1.0]), draw.between(0.2, 0.8), draw.log(0.3, 4.0));
    let encoder =
        draw.one(&["", ", encoder_bits = 12", ", encoder_noise_deg = 0.05, encoder_bias_deg = -0.3"]);
    let pointing = if draw.chance(0.5) {
        let rate_deg_s = (sense * across_deg * draw.log(0.5, 100.0) / lasts_s).clamp(-3600.0, 3600.0);
        let start_deg = (bearing_deg - share * lasts_s * rate_deg_s) % 360.0;
        let rpm = rate_deg_s / 6.0;
        format!(
            "kind = \"scan\", rpm = {rpm:?}, start_deg = {start_deg:?}, elevation_deg = {elevation_deg:?}"
        )
    } else {
        let half_deg = (across_deg * draw.log(0.3, 3.0)).min(80.0);
        let [from, to] = [-sense, sense].map(|side| bearing_deg + side * half_deg);
        let rate_deg_s = (2.0 * half_deg * turns / lasts_s).min(3600.0);
        let turn_ms = (draw.log(0.01, 0.5) * lasts_s * 1e3).max(1.0);
        let second_deg = (elevation_deg + draw.between(-1.0, 1.0) * across_deg).clamp(-89.0, 89.0);
        format!(
            "kind = \"sector\", from_deg = {from:?}, to_deg = {to:?}, rate_degps = {rate_deg_s:?}, turn_ms = {turn_ms:?}, \
             elevations_deg = [{elevation_deg:?}, {second_deg:?}]"
        )
    };
    (level_m < 1e5).then(|| format!("{{ {pointing}, about = \"north\"{encoder} }}"))
}

/// A transmitter and a receiver, their beams narrower by a factor than drawn.
pub(super) fn antennas([draw, scan]: [&mut Draw; 2], geometry: &Geometry, times: f64, out: &mut String) {
    let scans = !geometry.above && scan.chance(0.15);
    let Geometry { size_m, own, other, .. } = geometry;
    let wavelength_m = LIGHT_MPS / geometry.carrier_hz;
    for (n, role) in ["transmitter", "receiver"].into_iter().enumerate() {
        let platform = if geometry.bistatic { n } else { 0 };
        let flight = if n == 0 { own } else { other };
        let range_m = flight.position_m.iter().map(|x| x * x).sum::<f64>().sqrt();
        let size = size_m[0].max(size_m[1]);
        // A beam of a third of the patch to many times it, and sometimes narrower.
        let mut across =
            || (wavelength_m * range_m / (size * times * draw.log(0.4, 8.0))).clamp(0.6 * wavelength_m, 12.0);
        let (width_m, height_m) = (across(), across());
        let antenna = match draw.0.next_u64() % 10 {
            0..=1 => format!("{{ kind = \"isotropic\", gain_dbi = {:?} }}", draw.between(0.0, 20.0)),
            2 => format!("{{ kind = \"circle\", diameter_m = {width_m:?} }}"),
            3..=4 => format!("{{ kind = \"ellipse\", width_m = {width_m:?}, height_m = {height_m:?} }}"),
            _ => format!(
                "{{ kind = \"rectangle\", width_m = {width_m:?}, height_m = {height_m:?}{} }}",
                tapers(scan)
            ),
        };
        line!(out, "[[{role}]]\nname = \"a{n}\"\nplatform = \"p{platform}\"");
        if n == 0 {
            line!(out, "power_w = 10.0");
        }
        if draw.chance(0.15) {
            line!(out, "lever_arm_m = [{:?}, {:?}, 0.5]", draw.between(-2.0, 2.0), draw.between(-1.0, 1.0));
        }
        if draw.chance(0.15) {
            line!(out, "cross_pol_isolation_db = {:?}", draw.between(20.0, 40.0));
        }
        line!(out, "antenna = {antenna}");
        // From above also past the patch: what lies below is then in side lobes.
        let far = if geometry.above && draw.chance(0.6) { draw.log(1.0, 100.0) } else { 1.0 };
        let off = [0, 1].map(|i| far * draw.between(-0.3, 0.3) * size_m[i]);
        match scanning(scan, geometry, flight).filter(|_| scans) {
            Some(pointing) => line!(out, "pointing = {pointing}"),
            None => {
                line!(out, "pointing = {{ kind = \"at\", position_m = [{:?}, {:?}, 0.0] }}", off[0], off[1])
            }
        }
    }
}

/// Now and then one or two emitters, seldom or often heard, near the carrier or on it, weak or strong.
pub(super) fn emitters(
    [draw, kinds, streams]: [&mut Draw; 3],
    (geometry, signal): (&Geometry, &Signal),
    out: &mut String,
) {
    if !draw.chance(0.2) {
        return;
    }
    for n in 0..draw.one(&[1, 1, 2]) {
        platform(&format!("e{n}"), Flight::drawn(draw, geometry.partner, geometry.lasts_s), out);
        let prf_hz = draw.log(0.3 * geometry.prf_hz, 10.0 * geometry.prf_hz);
        let bandwidth_hz = draw.log(0.01, 1.5) * signal.rate_hz;
        let longest_s = (0.3 * signal.samples as f64 / signal.rate_hz).min(1.0 / prf_hz);
        let pulse_s = draw.log((2.0 / bandwidth_hz).min(0.5 * longest_s), longest_s);
        let carrier_hz = geometry.carrier_hz + draw.between(-0.4, 0.4) * signal.rate_hz;
        line!(
            out,
            "[[emitter]]\nname = \"c{n}\"\nplatform = \"e{n}\"\npower_w = {:?}\ncarrier_hz = {carrier_hz:?}\n{LOOKS}",
            draw.log(1e-4, 10.0)
        );
        let sweep = format!("bandwidth_hz = {bandwidth_hz:?}, pulse_s = {pulse_s:?}");
        let radiated = waveform(kinds, sweep, bandwidth_hz, pulse_s).join(", ");
        let endless = endless(streams, signal.rate_hz);
        let radiated = endless.as_ref().map_or(&radiated, |(keys, _)| keys);
        line!(
            out,
            "waveform = {{ {} }}\npolarisation = \"{}\"\ndirect_path = {}",
            radiated,
            draw.one(&["H", "V", "R", "L"]),
            draw.chance(0.7)
        );
        let staggered = draw.chance(0.3);
        let prf_hz = endless.as_ref().map_or(prf_hz, |(_, prf_hz)| *prf_hz);
        if staggered && endless.is_none() {
            let interval_us = 1e6 / prf_hz;
            line!(out, "pri_us = [{interval_us:?}, {:?}]", 1.1 * interval_us);
        } else {
            line!(out, "prf_hz = {prf_hz:?}");
        }
        if draw.chance(0.5) {
            // Some intervals sooner or later than the radar.
            line!(out, "start_us = {:?}", draw.between(-4.0, 4.0) * 1e6 / prf_hz);
        }
    }
}

/// Now and then another transmitter, and receivers elsewhere: with windows of their own that follow or are
/// fixed, on their own platform or beside others, some of which hear one transmitter alone.
pub(super) fn more_ends(draw: &mut Draw, (geometry, signal): (&Geometry, &Signal), out: &mut String) {
    if !draw.chance(0.25) {
        return;
    }
    let (looks, sends) = (LOOKS, draw.chance(0.3));
    let place = |flight, n: usize, out: &mut String| platform(&format!("q{n}"), flight, out);
    if sends {
        place(Flight::drawn(draw, geometry.kind, geometry.lasts_s), 0, out);
        line!(out, "[[transmitter]]\nname = \"b0\"\nplatform = \"q0\"\npower_w = 5.0\n{looks}");
    }
    for n in 1..=draw.one(&[1, 1, 2]) {
        let flight = Flight::drawn(draw, geometry.partner, geometry.lasts_s);
        let apart = draw.chance(0.8);
        if apart {
            place(flight, n, out);
        }
        let platform = if apart { format!("q{n}") } else { "p0".to_owned() };
        line!(out, "[[receiver]]\nname = \"b{n}\"\nplatform = \"{platform}\"\n{looks}");
        if sends && draw.chance(0.6) {
            line!(out, "hears = [\"{}\"]", draw.one(&["a0", "b0"]));
        }
        // What the patch returns to it of the first transmitter.
        let mut own = *geometry;
        own.other = if apart { flight } else { geometry.own };
        let [nearest_s, farthest_s] = own.delays_s();
        match draw.0.next_u64() % 3 {
            0 => line!(out, "window = {{ start_us = {:?} }}", 1e6 * nearest_s),
            1 => {
                let lead_us =
                    1e6 * (0.5 * (farthest_s - nearest_s)).min(0.4 * signal.samples as f64 / signal.rate_hz);
                line!(
                    out,
                    "window = {{ follow = {{ kind = \"at\", position_m = [0.0, 0.0, 0.0], lead_us = {lead_us:?} }} }}"
                );
            }
            // That of all.
            _ => {}
        }
    }
}
