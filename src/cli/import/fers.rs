//! Scenes of FERS as scenarios.
//!
//! Read are documents of `fers-xml` as of FERS 1.0 (`waveform`, `pulsed_mode`) and of its releases before
//! (`pulse`). One transmitter becomes that of the radar, all others [`[[emitter]]`](crate::scene): FERS adds
//! what a receiver hears of all, and nereus separates the transmitters of one radar.
//!
//! | FERS | scenario |
//! | --- | --- |
//! | x, y, altitude | East, North, up in a scene without origin, on a flat earth |
//! | azimuth, elevation | `pointing`, clockwise from North; a constant rate of azimuth is a scan |
//! | `static`, `linear`, `cubic` paths | fixed, straight, or a track of 2000 fixes |
//! | scalar fields | channel HH |
//! | `noise_temp` T | noise figure `T / 290 K`, of the whole radar |
//!
//! Source: the schema `fers-xml.dtd` of FERS 1.0, and its documentation.

use std::path::Path;

use super::motion::{Interpolation, Motion, Waypoint, csv};
use super::radiated::{Signal, mode};
use super::reading::{Names, Reading};
use super::scene::{ANY, Import, NOT_NEGATIVE, put};
use super::tree::Element;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Noise of an ideal receiver, K.
const T0_K: f64 = 290.0;

/// A scenario and the files beside it.
#[derive(Debug)]
pub(super) struct Imported {
    pub scenario: String,
    pub files: Vec<(String, String)>,
    pub left_out: Vec<String>,
}

/// A platform of the document.
struct Carrier<'a> {
    element: &'a Element,
    name: String,
    motion: Motion,
    pointing: String,
}

/// What sends or receives.
struct Node<'a> {
    element: &'a Element,
    carrier: usize,
}

/// Makes a scenario of a document; `folder` has the files that it names, `radar` is the transmitter to take
/// as that of the radar, the first unless it is given.
///
/// # Errors
/// All faults of the document, a line each.
pub(super) fn import(root: &Element, folder: &Path, radar: Option<&str>) -> Result<Imported, Vec<String>> {
    let mut reading = Reading::default();
    if root.name != "simulation" {
        reading.fault(root, "is not the root of a FERS document; allowed: <simulation>");
        return Err(reading.faults);
    }
    let missing = Element::default();
    let parameters = root.child("parameters").unwrap_or_else(|| {
        reading.fault(root, "<parameters> is missing");
        &missing
    });
    let begin_s = reading.number(parameters, "starttime", ANY);
    let end_s = reading.number(parameters, "endtime", ANY);
    if end_s <= begin_s && reading.faults.is_empty() {
        reading.fault(parameters, "allowed: an endtime after the starttime");
    }
    let rate_hz = reading.number(parameters, "rate", [1000.0, 1e11]);
    let unit = parameters.child("rotationangleunit").map_or("deg", Element::text);
    let mut import = Import {
        reading,
        folder,
        names: Names::default(),
        files: Vec::new(),
        waveforms: root.all("waveform").chain(root.all("pulse")).collect(),
        antennas: root.all("antenna").collect(),
        rate_hz,
        begin_s,
        end_s,
        in_degrees: !unit.starts_with("rad"),
    };
    let text = import.scenario(root, parameters, radar);
    let Import { reading: Reading { faults, left_out }, files, .. } = import;
    if faults.is_empty() { Ok(Imported { scenario: text, files, left_out }) } else { Err(faults) }
}

impl<'a> Import<'a> {
    fn scenario(&mut self, root: &'a Element, parameters: &Element, radar: Option<&str>) -> String {
        self.note_parameters(parameters);
        root.all("include")
            .for_each(|own| self.reading.fault(own, "is not followed; write its content here"));
        for timing in root.all("timing") {
            let errors = timing.children.iter().filter(|own| own.name != "frequency");
            for own in errors.filter(|own| own.child("weight").or(Some(own)).is_some_and(|w| w.text() != "0"))
            {
                let what = format!("<{}> of a clock: see [transmitter.clock] of docs/scenario.md", own.name);
                self.reading.leave_out(own, what);
            }
        }
        let (mut carriers, mut nodes) = (Vec::new(), Vec::new());
        for element in root.all("platform") {
            let of = element.children.iter().filter(|own| is_radar(own));
            nodes.extend(of.map(|element| Node { element, carrier: carriers.len() }));
            let (motion, pointing) = (self.motion(element), self.pointing(element));
            carriers.push(Carrier { element, name: self.names.give(element), motion, pointing });
        }
        let senders: Vec<&Node<'a>> = nodes.iter().filter(|own| own.element.name != "receiver").collect();
        let first = match radar {
            Some(name) => senders.iter().find(|own| own.element.attribute("name") == Some(name)),
            None => senders.iter().find(|own| self.is_understood(own.element)).or(senders.first()),
        };
        let Some(&first) = first else {
            let known: Vec<&str> = senders.iter().filter_map(|own| own.element.attribute("name")).collect();
            let asked = radar.map_or("no transmitter".to_owned(), |name| format!("no transmitter '{name}'"));
            self.reading.fault(root, format_args!("{asked}; allowed: {}", known.join(", ")));
            return String::new();
        };
        let Some(signal) = self.signal(first.element, self.rate_hz) else { return String::new() };
        let mut text = self.head(root, parameters, &signal);
        self.window_and_noise(&mut text, first, &nodes, &signal);
        for carrier in &carriers {
            if carrier.element.children.iter().any(is_radar) {
                self.platform(&mut text, carrier);
            }
        }
        self.sender(&mut text, "transmitter", first, &carriers, &signal);
        self.receivers(&mut text, first, &nodes, &carriers, &signal);
        for other in senders.into_iter().filter(|own| !std::ptr::eq(*own, first)) {
            self.emitter(&mut text, other, &carriers, &signal);
        }
        for carrier in &carriers {
            for target in carrier.element.all("target") {
                self.target(&mut text, target, carrier);
            }
        }
        text.push_str("\n[[sink]]\nkind = \"hdf5\"\npath = \"scenario.h5\"\n");
        text
    }

    /// What of the parameters has no place.
    fn note_parameters(&mut self, parameters: &Element) {
        for own in &parameters.children {
            let why = match own.name.as_str() {
                "adc_bits" | "adcbits" if own.text() != "0" => {
                    "quantisation: FERS scales every window to its converter; give [radar.adc] a full scale"
                }
                "c" if own.text().parse().is_ok_and(|c: f64| (c - SPEED_OF_LIGHT_MPS).abs() > 1.0) => {
                    "another speed of light"
                }
                "origin" => "the origin, which FERS itself uses for maps alone",
                _ => continue,
            };
            self.reading.leave_out(own, why);
        }
    }

    fn head(&mut self, root: &Element, parameters: &Element, signal: &Signal) -> String {
        let seed = self.reading.optional(parameters, "randomseed", [0.0, 9e15]).unwrap_or(0.0);
        let name = root.attribute("name").unwrap_or("unnamed").replace(char::is_control, " ");
        let mut text = format!(
            "# {name}: imported from FERS. FERS adds scalars; this is HH.\n\n[scene]\n\
             start_utc = \"2000-01-01T00:00:00Z\"       # FERS: {} s\nduration_s = {:?}\nseed = {seed}\n\n[radar]\n",
            self.begin_s,
            self.end_s - self.begin_s
        );
        let pri_us = signal.pri_s * 1e6;
        put(&mut text, format_args!("carrier_hz = {:?}", signal.carrier_hz));
        put(&mut text, format_args!("sample_rate_hz = {:?}", self.rate_hz));
        put(&mut text, format_args!("pri_us = [{pri_us:?}]"));
        put(&mut text, format_args!("channels = [\"HH\"]"));
        put(&mut text, format_args!("waveform = {}", signal.toml));
        text
    }

    fn window_and_noise(&mut self, text: &mut String, first: &Node<'a>, nodes: &[Node<'a>], signal: &Signal) {
        let hearing: Vec<&Node<'a>> = nodes.iter().filter(|own| hears(own) && follows(own, signal)).collect();
        let mut temperatures_k: Vec<f64> = Vec::new();
        for own in &hearing {
            temperatures_k.extend(self.reading.optional(own.element, "noise_temp", NOT_NEGATIVE));
            if own.element.attribute("nopropagationloss") == Some("true") {
                self.reading.leave_out(own.element, "nopropagationloss: paths lose what they lose");
            }
        }
        let most_k = temperatures_k.iter().copied().fold(0.0, f64::max);
        if most_k > 0.0 {
            let figure_db = 10.0 * (most_k / T0_K).max(1.0).log10();
            put(text, format_args!("noise_figure_db = {figure_db:?}"));
            if temperatures_k.iter().any(|own| *own != most_k) || most_k < T0_K {
                let own_k = most_k.max(T0_K);
                let what = format!("noise temperatures: all receivers have {own_k} K, no less than {T0_K} K");
                self.reading.left_out.push(what);
            }
        }
        let apart = hearing.iter().all(|own| own.carrier != first.carrier);
        let direct = hearing.iter().filter(|own| own.element.name == "receiver");
        let direct = direct.filter(|own| own.element.attribute("nodirect") != Some("true")).count() > 0;
        if direct && !apart {
            self.reading
                .leave_out(first.element, "direct paths: a receiver is on the transmitter's platform");
        }
        put(text, format_args!("direct_path = {}", direct && apart));
        let of = |reading: &mut Reading, own: &Node<'a>| window(reading, own.element, self.rate_hz);
        let windows: Vec<(f64, f64)> = if signal.is_continuous {
            Vec::new()
        } else {
            hearing.iter().map(|own| of(&mut self.reading, own)).collect()
        };
        let samples = windows.iter().map(|(_, samples)| *samples).fold(1.0, f64::max);
        match windows.first() {
            None => {
                let samples = (self.rate_hz * signal.pri_s).round().clamp(1.0, 16_777_216.0);
                put(text, format_args!("window = {{ gate = \"continuous\", samples = {samples} }}"));
            }
            Some((start_us, _)) => {
                put(text, format_args!("window = {{ start_us = {start_us:?}, samples = {samples} }}"));
                if windows.iter().any(|(_, own)| *own != samples) {
                    let what = format!("windows of different lengths: all have {samples} samples");
                    self.reading.left_out.push(what);
                }
            }
        }
    }

    fn platform(&mut self, text: &mut String, of: &Carrier<'_>) {
        let track = match &of.motion {
            Motion::Fixed(place_m) => format!("{{ kind = \"fixed\", position_m = {place_m:?} }}"),
            Motion::Straight(place_m, velocity_mps) => format!(
                "{{ kind = \"straight\", position_m = {place_m:?}, velocity_mps = {velocity_mps:?}, \
                 yaw_deg = 0.0, pitch_deg = 0.0 }}"
            ),
            Motion::Track(track, step_s) => {
                let (file, gap_s) = (format!("{}.csv", of.name), 1.5 * step_s);
                self.files.push((file.clone(), csv(track)));
                format!(
                    "{{ kind = \"csv\", path = \"{file}\", attitude = \"constant\", max_gap_s = {gap_s:?} }}"
                )
            }
        };
        put(text, format_args!("\n[[platform]]\nname = \"{}\"\ntrack = {track}", of.name));
    }

    /// A transmitter or an emitter, up to its antenna.
    fn sender(
        &mut self,
        text: &mut String,
        kind: &str,
        node: &Node<'a>,
        carriers: &[Carrier<'_>],
        signal: &Signal,
    ) {
        let carrier = &carriers[node.carrier];
        let name = self.names.give(node.element);
        put(text, format_args!("\n[[{kind}]]\nname = \"{name}\"\nplatform = \"{}\"", carrier.name));
        put(text, format_args!("power_w = {:?}", signal.power_w));
        self.antenna(text, node.element, signal.carrier_hz, &name);
        put(text, format_args!("pointing = {}", carrier.pointing));
    }

    fn receivers(
        &mut self,
        text: &mut String,
        first: &Node<'a>,
        nodes: &[Node<'a>],
        carriers: &[Carrier<'_>],
        signal: &Signal,
    ) {
        let mut written = 0;
        let mut common_us = None;
        for node in nodes.iter().filter(|own| hears(own)) {
            if !follows(node, signal) {
                let name = first.element.attribute("name").unwrap_or_default();
                let what = format!("a receiver without the PRF of '{name}'; --radar takes another radar");
                self.reading.leave_out(node.element, what);
                continue;
            }
            let carrier = &carriers[node.carrier];
            let base = self.names.give(node.element);
            put(text, format_args!("\n[[receiver]]\nname = \"{base}\"\nplatform = \"{}\"", carrier.name));
            self.antenna(text, node.element, signal.carrier_hz, &base);
            put(text, format_args!("pointing = {}", carrier.pointing));
            if !signal.is_continuous {
                let (start_us, _) = window(&mut self.reading, node.element, self.rate_hz);
                if *common_us.get_or_insert(start_us) != start_us {
                    put(text, format_args!("window = {{ start_us = {start_us:?} }}"));
                }
            }
            written += 1;
        }
        if written == 0 {
            self.reading.fault(first.element, "no receiver takes it; allowed: one of its PRF at least");
        }
    }

    fn emitter(&mut self, text: &mut String, node: &Node<'a>, carriers: &[Carrier<'_>], radar: &Signal) {
        if !self.is_understood(node.element) {
            self.reading.leave_out(node.element, "a transmitter of CW, steps or a continuous file");
            return;
        }
        let Some(own) = self.signal(node.element, self.rate_hz) else { return };
        if (own.carrier_hz - radar.carrier_hz).abs() > 0.5 * self.rate_hz {
            self.reading.leave_out(node.element, "a transmitter outside the band that receivers sample");
            return;
        }
        self.sender(text, "emitter", node, carriers, &own);
        put(text, format_args!("carrier_hz = {:?}", own.carrier_hz));
        put(text, format_args!("pri_us = [{:?}]", own.pri_s * 1e6));
        put(text, format_args!("waveform = {}", own.toml));
    }

    fn target(&mut self, text: &mut String, target: &Element, on: &Carrier<'_>) {
        let missing = Element::default();
        let rcs = target.child("rcs").unwrap_or(&missing);
        if rcs.attribute("type") == Some("file") {
            self.reading.leave_out(rcs, "a target whose cross section is in a file: it has 1 m^2");
        }
        let rcs_m2 = match rcs.child("value") {
            Some(_) => self.reading.number(rcs, "value", [0.0, 1e12]),
            None => 1.0,
        };
        if target.child("model").is_some_and(|own| own.attribute("type") != Some("constant")) {
            self.reading.leave_out(target, "fluctuation of a target: see swerling of docs/scenario.md");
        }
        let name = self.names.give(target);
        put(text, format_args!("\n[[target]]\nname = \"{name}\"\nrcs_m2 = {rcs_m2:?}"));
        match &on.motion {
            Motion::Fixed(place_m) => put(text, format_args!("position_m = {place_m:?}")),
            Motion::Straight(place_m, velocity_mps) => {
                put(text, format_args!("position_m = {place_m:?}\nvelocity_mps = {velocity_mps:?}"));
            }
            Motion::Track(track, step_s) => {
                let (file, gap_s) = (format!("{name}.csv"), 1.5 * step_s);
                self.files.push((file.clone(), csv(track)));
                put(
                    text,
                    format_args!(
                        "track = {{ kind = \"csv\", path = \"{file}\", heights = \"recorded\", max_gap_s = {gap_s:?} }}"
                    ),
                );
            }
        }
    }

    fn motion(&mut self, platform: &Element) -> Motion {
        let missing = Element::default();
        let path = platform.child("motionpath").unwrap_or(&missing);
        let how = match path.attribute("interpolation").unwrap_or("static") {
            "static" => Interpolation::Static,
            "linear" => Interpolation::Linear,
            "cubic" => Interpolation::Cubic,
            other => {
                let what = format!("interpolation '{other}'; allowed: static, linear, cubic");
                self.reading.fault(path, what);
                Interpolation::Static
            }
        };
        let waypoints: Vec<Waypoint> = path
            .all("positionwaypoint")
            .map(|own| ["time", "x", "y", "altitude"].map(|name| self.reading.number(own, name, ANY)))
            .collect();
        if waypoints.is_empty() || !waypoints.is_sorted_by(|a, b| a[0] < b[0]) {
            self.reading.fault(platform, "allowed: a motionpath of waypoints whose times rise");
            return Motion::Fixed([0.0; 3]);
        }
        let motion = Motion::of(&waypoints, how, [self.begin_s, self.end_s]);
        if how == Interpolation::Linear && matches!(motion, Motion::Track(..)) {
            self.reading.leave_out(path, "corners of a path: between fixes of the track it bends smoothly");
        }
        motion
    }

    fn pointing(&mut self, platform: &Element) -> String {
        let missing = Element::default();
        let turn = if self.in_degrees { 1.0 } else { 1f64.to_degrees() };
        if let Some(fixed) = platform.child("fixedrotation") {
            let names = ["startazimuth", "startelevation", "azimuthrate", "elevationrate"];
            let [az, el, rate, rise] = names.map(|name| turn * self.reading.number(fixed, name, ANY));
            if rise != 0.0 {
                self.reading.leave_out(fixed, "elevationrate");
            }
            if rate != 0.0 {
                let start_deg = (az + rate * self.begin_s) % 360.0;
                let (rpm, el) = (rate / 6.0, el.clamp(-90.0, 90.0));
                return format!(
                    "{{ kind = \"scan\", about = \"north\", rpm = {rpm:?}, start_deg = {start_deg:?}, \
                     elevation_deg = {el:?} }}"
                );
            }
            return fixed_at(az, el);
        }
        let path = platform.child("rotationpath").unwrap_or(&missing);
        let mut all = path.all("rotationwaypoint");
        let Some(first) = all.next() else { return fixed_at(0.0, 0.0) };
        let [az, el] = ["azimuth", "elevation"].map(|name| turn * self.reading.number(first, name, ANY));
        if all.next().is_some() && path.attribute("interpolation") != Some("static") {
            self.reading.leave_out(
                path,
                "a rotationpath: it stays as at its first waypoint; see pointing \"sector\"",
            );
        }
        fixed_at(az, el)
    }
}

fn is_radar(own: &Element) -> bool {
    ["monostatic", "transmitter", "receiver"].contains(&own.name.as_str())
}

fn hears(own: &&Node<'_>) -> bool {
    own.element.name != "transmitter"
}

/// Whether a receiver goes by the PRF of the radar, or is continuous as it is.
fn follows(node: &Node<'_>, signal: &Signal) -> bool {
    let prf_hz = mode(node.element).and_then(|own| own.child("prf"));
    let prf_hz: Option<f64> = prf_hz.and_then(|own| own.text().parse().ok());
    match prf_hz {
        Some(prf_hz) => !signal.is_continuous && (prf_hz * signal.pri_s - 1.0).abs() < 1e-9,
        None => signal.is_continuous,
    }
}

/// Start after the emission, us, and samples of a receiver's window.
fn window(reading: &mut Reading, node: &Element, rate_hz: f64) -> (f64, f64) {
    let own = mode(node).unwrap_or(node);
    let skip_s = reading.optional(own, "window_skip", [0.0, 10.0]).unwrap_or(0.0);
    let length_s = reading.number(own, "window_length", [1e-9, 10.0]);
    (skip_s * 1e6, (length_s * rate_hz).round().clamp(1.0, 16_777_216.0))
}

fn fixed_at(az_deg: f64, el_deg: f64) -> String {
    let (yaw, pitch) = (az_deg % 360.0, el_deg.clamp(-90.0, 90.0));
    format!("{{ kind = \"fixed\", yaw_deg = {yaw:?}, pitch_deg = {pitch:?} }}")
}
