//! What the antennas and transmitters of a FERS scene radiate: patterns and waveforms.

use std::path::Path;

use super::antenna::Pattern;
use super::pulse_file;
use super::scene::{ANY, Import, NOT_NEGATIVE, POSITIVE, put};
use super::tree::Element;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Waveforms that have a place in a scenario.
const KINDS: [&str; 3] = ["pulsed_from_file", "fmcw_linear_chirp", "fmcw_triangle"];

/// What becomes the table `waveform`, and with it the rest of what a transmitter radiates.
pub(super) struct Signal {
    pub power_w: f64,
    pub carrier_hz: f64,
    pub pri_s: f64,
    pub toml: String,
    pub is_continuous: bool,
}

impl Import<'_> {
    pub fn antenna(&mut self, text: &mut String, node: &Element, carrier_hz: f64, name: &str) {
        let Some(own) = self.reading.named(node, "antenna", &self.antennas) else { return };
        let pattern = self.pattern(own, SPEED_OF_LIGHT_MPS / carrier_hz);
        let file = format!("{name}-antenna.csv");
        put(text, format_args!("antenna = {}", pattern.toml(&file)));
        self.files.extend(pattern.table().map(|table| (file, table)));
    }

    fn pattern(&mut self, own: &Element, wavelength_m: f64) -> Pattern {
        let efficiency = self.reading.optional(own, "efficiency", POSITIVE).unwrap_or(1.0);
        let pi = std::f64::consts::PI;
        match own.attribute("pattern").unwrap_or_default() {
            "isotropic" => Pattern::Isotropic { gain: efficiency },
            "sinc" => Pattern::Sinc {
                gain: efficiency * self.reading.number(own, "alpha", POSITIVE),
                per_rad: self.reading.number(own, "beta", POSITIVE),
                power: self.reading.number(own, "gamma", NOT_NEGATIVE),
            },
            // FERS does not apply its efficiency here.
            "gaussian" => Pattern::Gaussian {
                gain: 1.0,
                per_rad2: ["azscale", "elscale"].map(|name| self.reading.number(own, name, NOT_NEGATIVE)),
            },
            "squarehorn" => {
                let wavelengths = self.reading.number(own, "diameter", POSITIVE) / wavelength_m;
                Pattern::Horn { gain: efficiency * 4.0 * pi * wavelengths * wavelengths, wavelengths }
            }
            "parabolic" => {
                let diameter_m = self.reading.number(own, "diameter", POSITIVE);
                let wavelengths = diameter_m / wavelength_m;
                if efficiency == 1.0 {
                    return Pattern::Circle { diameter_m };
                }
                Pattern::Dish { gain: efficiency * (pi * wavelengths).powi(2), wavelengths }
            }
            other => {
                let what = format!("the pattern '{other}': the antenna is isotropic; see kind = \"file\"");
                self.reading.leave_out(own, what);
                Pattern::Isotropic { gain: efficiency }
            }
        }
    }

    /// Whether what a transmitter radiates has a place in a scenario; faults are left to [`Self::signal`].
    pub fn is_understood(&self, node: &Element) -> bool {
        let name = node.attribute("waveform").or(node.attribute("pulse"));
        let own = self.waveforms.iter().find(|own| own.attribute("name") == name);
        own.is_none_or(|own| own.name == "pulse" || KINDS.iter().any(|kind| own.child(kind).is_some()))
    }

    /// What a transmitter radiates.
    pub fn signal(&mut self, node: &Element, rate_hz: f64) -> Option<Signal> {
        let attribute = if node.attribute("waveform").is_some() { "waveform" } else { "pulse" };
        let own = self.reading.named(node, attribute, &self.waveforms)?;
        let power_w = self.reading.number(own, "power", POSITIVE);
        let carrier = if own.name == "pulse" { "carrier" } else { "carrier_frequency" };
        let mut carrier_hz = self.reading.number(own, carrier, POSITIVE);
        let file = own.child("pulsed_from_file").or(Some(own).filter(|own| own.name == "pulse"));
        if let Some(file) = file {
            let Some(mode) = mode(node) else {
                self.reading.fault(node, "<pulsed_mode> is missing");
                return None;
            };
            let prf_hz = self.reading.number(mode, "prf", POSITIVE);
            let toml = self.pulse_file(file, rate_hz)?;
            return Some(Signal { power_w, carrier_hz, pri_s: 1.0 / prf_hz, toml, is_continuous: false });
        }
        let chirp = own.child("fmcw_linear_chirp");
        let Some(sweep) = chirp.or_else(|| own.child("fmcw_triangle")) else {
            self.reading.fault(own, format_args!("allowed: {}", KINDS.join(", ")));
            return None;
        };
        let bandwidth_hz = self.reading.number(sweep, "chirp_bandwidth", POSITIVE);
        let pulse_s = self.reading.number(sweep, "chirp_duration", POSITIVE);
        let offset_hz = self.reading.optional(sweep, "start_frequency_offset", ANY).unwrap_or(0.0);
        let down = sweep.attribute("direction") == Some("down");
        carrier_hz += offset_hz + if down { -0.5 } else { 0.5 } * bandwidth_hz;
        let (word, pulse_s, pri_s) = match chirp {
            Some(_) => {
                let pri_s = self.reading.number(sweep, "chirp_period", POSITIVE);
                (if down { "down" } else { "up" }, pulse_s, pri_s)
            }
            None => ("triangular", 2.0 * pulse_s, 2.0 * pulse_s),
        };
        for name in ["chirp_count", "triangle_count"] {
            sweep
                .all(name)
                .for_each(|own| self.reading.leave_out(own, format_args!("<{name}>: sweeps go on")));
        }
        let dechirps = node.child("fmcw_mode").and_then(|own| own.attribute("dechirp_mode"));
        if dechirps.is_some_and(|mode| mode != "none") {
            self.reading.leave_out(node, "dechirp: see [radar.dechirp] of docs/scenario.md");
        }
        let toml = format!(
            "{{ kind = \"lfm\", sweep = \"{word}\", bandwidth_hz = {bandwidth_hz:?}, pulse_s = {pulse_s:?} }}"
        );
        Some(Signal { power_w, carrier_hz, pri_s, toml, is_continuous: true })
    }

    /// A waveform of samples, put beside the scenario once.
    fn pulse_file(&mut self, of: &Element, rate_hz: f64) -> Option<String> {
        let given = of.attribute("filename").unwrap_or_default();
        let path = self.folder.join(given);
        let pulse = match pulse_file::read(&path) {
            Ok(pulse) => pulse,
            Err(error) => {
                self.reading.fault(of, format_args!("filename '{given}': {error}"));
                return None;
            }
        };
        let stem = Path::new(given).file_stem().map_or("pulse".into(), |stem| stem.to_string_lossy());
        let legal = |c: char| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' };
        let name = format!("{}-waveform.csv", stem.chars().map(legal).collect::<String>());
        let text = pulse_file::csv(&pulse.samples);
        if !self.files.iter().any(|(own, _)| *own == name) {
            self.files.push((name.clone(), text));
        }
        let rate_hz = pulse.rate_hz.unwrap_or(rate_hz);
        Some(format!("{{ kind = \"file\", path = \"{name}\", rate_hz = {rate_hz:?} }}"))
    }
}

/// Where the PRF and the window stand; before FERS 1.0 in the radar itself.
pub(super) fn mode(node: &Element) -> Option<&Element> {
    node.child("pulsed_mode").or(Some(node).filter(|own| own.child("prf").is_some()))
}
