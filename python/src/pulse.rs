//! A pulse as Python sees it.

use std::sync::Arc;

use nereus::Samples;
use nereus::pulse::{AntennaRecord, PlatformRecord};
use nereus::recording::header::Header;
use num_complex::Complex32;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;

type Vector<'py> = Bound<'py, PyArray1<f64>>;

/// One pulse: samples, time, navigation, truth.
#[pyclass(frozen, module = "nereus")]
pub(crate) struct Pulse {
    record: Box<nereus::Pulse>,
    header: Arc<Header>,
    /// Set at once without a converter; of codes when it is asked for.
    iq: PyOnceLock<Py<PyArray2<Complex32>>>,
    codes: Option<Py<PyArray3<i16>>>,
    reported: PyOnceLock<Py<PyDict>>,
    truth: PyOnceLock<Py<PyDict>>,
    antennas: PyOnceLock<Py<PyDict>>,
}

/// Where a platform is, or reports that it is, at the emission of a pulse (East, North, up).
#[pyclass(frozen, module = "nereus")]
pub(crate) struct Platform(PlatformRecord);

/// Where an antenna is and looks at the emission of a pulse (East, North, up).
#[pyclass(frozen, module = "nereus")]
pub(crate) struct Antenna(AntennaRecord);

/// Where a ship is at the emission of a pulse (East, North, up).
#[pyclass(frozen, module = "nereus")]
pub(crate) struct Ship {
    position_m: [f64; 3],
    velocity_mps: [f64; 3],
    /// Clockwise from North, degrees.
    #[pyo3(get)]
    heading_deg: f64,
}

impl Pulse {
    /// Takes the memory of the samples over; nothing of them is copied.
    pub(crate) fn new(
        py: Python<'_>,
        mut record: Box<nereus::Pulse>,
        header: &Arc<Header>,
    ) -> PyResult<Self> {
        let (channels, samples) = (header.layout.channels, header.layout.samples);
        let iq = PyOnceLock::new();
        let mut codes = None;
        match std::mem::replace(&mut record.samples, Samples::Cf32(Vec::new())) {
            Samples::Cf32(all) => {
                let _ = iq.set(py, all.into_pyarray(py).reshape([channels, samples])?.unbind());
            }
            Samples::Ci16(all) => {
                let flat: Vec<i16> = all.into_flattened();
                codes = Some(flat.into_pyarray(py).reshape([channels, samples, 2])?.unbind());
            }
        }
        Ok(Self {
            record,
            header: Arc::clone(header),
            iq,
            codes,
            reported: PyOnceLock::new(),
            truth: PyOnceLock::new(),
            antennas: PyOnceLock::new(),
        })
    }

    fn platforms(&self, py: Python<'_>, records: &[PlatformRecord]) -> PyResult<Py<PyDict>> {
        let dict = PyDict::new(py);
        for (name, record) in self.header.platforms.iter().zip(records) {
            dict.set_item(name, Platform(*record))?;
        }
        Ok(dict.unbind())
    }

    /// Values of every pair and target.
    fn of_targets<'py>(&self, py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyArray2<f64>>> {
        PyArray1::from_slice(py, values).reshape([self.header.pairs.len(), self.header.targets.len()])
    }
}

#[pymethods]
impl Pulse {
    /// Number of the pulse in the run, from 0.
    #[getter]
    fn index(&self) -> u64 {
        self.record.index
    }

    /// Emission, UTC nanoseconds since 1970, rounded down.
    #[getter]
    fn time_ns(&self) -> i64 {
        self.record.time.to_unix_ns().0
    }

    /// The rest of it, in [0, 1) ns.
    #[getter]
    fn time_frac_ns(&self) -> f64 {
        self.record.time.to_unix_ns().1
    }

    /// First sample minus emission, s: of all channels, or of the first.
    #[getter]
    fn window_start_s(&self) -> f64 {
        self.record.window_start_s
    }

    /// The same of every receiver, float64 [receiver], in the order of the header.
    #[getter]
    fn receiver_window_start_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let receivers = 0..self.header.receivers.len();
        PyArray1::from_vec(py, receivers.map(|receiver| self.record.window_start_of(receiver)).collect())
    }

    /// Bits of `nereus.Flag`.
    #[getter]
    fn flags(&self) -> u32 {
        self.record.flags
    }

    /// What was radiated: 0 all ports at once, 1 H, 2 V, 3 right, 4 left circular.
    #[getter]
    fn tx_pol(&self) -> u8 {
        self.record.tx_pol
    }

    /// Samples, complex64 [channel, sample], sqrt(W): memory of its own, which nothing else writes to.
    #[getter]
    fn iq(&self, py: Python<'_>) -> PyResult<Py<PyArray2<Complex32>>> {
        let of_codes = || {
            let codes = self.codes.as_ref().map(|codes| codes.bind(py).readonly());
            let step = self.header.adc.map_or(1.0, |adc| adc.step) as f32;
            let flat = codes.as_ref().map_or(Ok(&[][..]), |codes| codes.as_slice())?;
            let pairs = flat.chunks_exact(2);
            let value = |code: i16| (f32::from(code) + 0.5) * step;
            let all: Vec<Complex32> =
                pairs.map(|pair| Complex32::new(value(pair[0]), value(pair[1]))).collect();
            let shape = [self.header.layout.channels, self.header.layout.samples];
            PyResult::Ok(all.into_pyarray(py).reshape(shape)?.unbind())
        };
        self.iq.get_or_try_init(py, of_codes).map(|iq| iq.clone_ref(py))
    }

    /// ADC codes, int16 [channel, sample, 2] (in-phase, quadrature); None without a converter.
    #[getter]
    fn codes(&self, py: Python<'_>) -> Option<Py<PyArray3<i16>>> {
        self.codes.as_ref().map(|codes| codes.clone_ref(py))
    }

    /// What every platform reports, by name.
    #[getter]
    fn reported(&self, py: Python<'_>) -> PyResult<Py<PyDict>> {
        let make = || self.platforms(py, &self.record.nav_reported);
        self.reported.get_or_try_init(py, make).map(|dict| dict.clone_ref(py))
    }

    /// Where every platform is, by name; empty where the truth is not known (`nereus.receive`).
    #[getter]
    fn truth(&self, py: Python<'_>) -> PyResult<Py<PyDict>> {
        let records = if self.header.truth { &self.record.nav_true[..] } else { &[] };
        let make = || self.platforms(py, records);
        self.truth.get_or_try_init(py, make).map(|dict| dict.clone_ref(py))
    }

    /// Every transmitter and receiver, by name.
    #[getter]
    fn antennas(&self, py: Python<'_>) -> PyResult<Py<PyDict>> {
        let make = || {
            let dict = PyDict::new(py);
            for (name, record) in self.header.antennas().zip(&self.record.antennas) {
                dict.set_item(name, Antenna(*record))?;
            }
            PyResult::Ok(dict.unbind())
        };
        self.antennas.get_or_try_init(py, make).map(|dict| dict.clone_ref(py))
    }

    /// True delay of every target's echo, float64 [pair, target], s.
    #[getter]
    fn target_delay_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.of_targets(py, &self.record.target_delay_s)
    }

    /// True Doppler of every target's echo, float64 [pair, target], Hz, positive when closing.
    #[getter]
    fn target_doppler_hz<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.of_targets(py, &self.record.target_doppler_hz)
    }

    /// Every ship, by name.
    #[getter]
    fn ships<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let of = &self.record;
        let states = of.ship_position_m.iter().zip(&of.ship_velocity_mps).zip(&of.ship_heading_deg);
        for (name, ((position_m, velocity_mps), heading_deg)) in self.header.ships.iter().zip(states) {
            let (position_m, velocity_mps, heading_deg) = (*position_m, *velocity_mps, *heading_deg);
            dict.set_item(name, Ship { position_m, velocity_mps, heading_deg })?;
        }
        Ok(dict)
    }

    /// Reading minus time of every clock that is wrong, by antenna, s.
    #[getter]
    fn clocks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, x_s) in self.header.clocks.iter().zip(&self.record.clock_x_s) {
            dict.set_item(name, *x_s)?;
        }
        Ok(dict)
    }

    fn __repr__(&self) -> String {
        let layout = &self.header.layout;
        let (index, time, flags) = (self.record.index, self.record.time, self.record.flags);
        format!(
            "<nereus.Pulse {index} at {time}: {} channels of {} samples, flags {flags}>",
            layout.channels, layout.samples
        )
    }
}

#[pymethods]
impl Platform {
    /// Position, float64 [3], m.
    #[getter]
    fn position_m<'py>(&self, py: Python<'py>) -> Vector<'py> {
        PyArray1::from_slice(py, &self.0.position_m)
    }

    /// Velocity, float64 [3], m/s.
    #[getter]
    fn velocity_mps<'py>(&self, py: Python<'py>) -> Vector<'py> {
        PyArray1::from_slice(py, &self.0.velocity_mps)
    }

    /// Body (forward, starboard, down) to East, North, up: Hamilton's, [w, x, y, z].
    #[getter]
    fn attitude_quat<'py>(&self, py: Python<'py>) -> Vector<'py> {
        PyArray1::from_slice(py, &self.0.attitude_quat)
    }

    /// Roll (right wing down), pitch (nose up) and heading (clockwise from North, 0 to 360), float64 [3],
    /// deg.
    #[getter]
    fn attitude_deg<'py>(&self, py: Python<'py>) -> Vector<'py> {
        PyArray1::from_slice(py, &angles_deg(self.0.attitude_quat))
    }

    /// Emission minus the epoch of the navigation that this rests on, s.
    #[getter]
    fn age_s(&self) -> f64 {
        self.0.age_s
    }

    /// Bits of `nereus.Flag` that concern this platform.
    #[getter]
    fn flags(&self) -> u32 {
        self.0.flags
    }

    fn __repr__(&self) -> String {
        let ([e, n, u], [ve, vn, vu]) = (self.0.position_m, self.0.velocity_mps);
        format!("<nereus.Platform at [{e:.3}, {n:.3}, {u:.3}] m, [{ve:.3}, {vn:.3}, {vu:.3}] m/s>")
    }
}

#[pymethods]
impl Antenna {
    /// True phase centre, float64 [3], m.
    #[getter]
    fn phase_centre_m<'py>(&self, py: Python<'py>) -> Vector<'py> {
        PyArray1::from_slice(py, &self.0.phase_centre_m)
    }

    /// True axes (x the boresight, z up) to East, North, up: Hamilton's, [w, x, y, z].
    #[getter]
    fn boresight_quat<'py>(&self, py: Python<'py>) -> Vector<'py> {
        PyArray1::from_slice(py, &self.0.boresight_quat)
    }

    /// Phase centre by the reports of its platform, float64 [3], m.
    #[getter]
    fn reported_phase_centre_m<'py>(&self, py: Python<'py>) -> Vector<'py> {
        PyArray1::from_slice(py, &self.0.reported_phase_centre_m)
    }

    /// Azimuth and elevation that the encoder of its pedestal reads, float64 [2], degrees; None if it does
    /// not scan.
    #[getter]
    fn encoder_deg<'py>(&self, py: Python<'py>) -> Option<Vector<'py>> {
        self.0.encoder_deg.map(|reading_deg| PyArray1::from_slice(py, &reading_deg))
    }
}

#[pymethods]
impl Ship {
    /// Midship at the waterline, float64 [3], m.
    #[getter]
    fn position_m<'py>(&self, py: Python<'py>) -> Vector<'py> {
        PyArray1::from_slice(py, &self.position_m)
    }

    /// Velocity, float64 [3], m/s.
    #[getter]
    fn velocity_mps<'py>(&self, py: Python<'py>) -> Vector<'py> {
        PyArray1::from_slice(py, &self.velocity_mps)
    }
}

/// Roll, pitch and heading of a body whose axes a quaternion turns into East, North, up.
fn angles_deg([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    let forward =
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), (2.0 * (x * z - w * y)).clamp(-1.0, 1.0)];
    let (starboard_up, down_up) = (2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y));
    let roll = (-starboard_up).atan2(-down_up);
    let heading = forward[0].atan2(forward[1]).to_degrees().rem_euclid(360.0);
    // A hair West of North is rounded up to a whole turn.
    [roll.to_degrees(), forward[2].asin().to_degrees(), if heading < 360.0 { heading } else { 0.0 }]
}

/// A header as a dict.
pub(crate) fn described<'py>(py: Python<'py>, header: &Header) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    let channels: Vec<&str> = header.channels.iter().map(|row| row.name.as_str()).collect();
    let pairs: Vec<(&str, &str)> =
        header.pairs.iter().map(|pair| (pair.transmitter.as_str(), pair.receiver.as_str())).collect();
    let (start_time_ns, start_time_frac_ns) = header.start.to_unix_ns();
    dict.set_item("software", &header.software)?;
    dict.set_item("carrier_hz", header.carrier_hz)?;
    dict.set_item("sample_rate_hz", header.sample_rate_hz)?;
    dict.set_item("bandwidth_hz", header.bandwidth_hz)?;
    dict.set_item("pulse_s", header.pulse_s)?;
    dict.set_item("prf_hz", header.prf_hz)?;
    dict.set_item("continuous", header.is_continuous())?;
    dict.set_item("channels", channels)?;
    dict.set_item("samples", header.layout.samples)?;
    dict.set_item("pairs", pairs)?;
    dict.set_item("platforms", &header.platforms)?;
    dict.set_item("transmitters", &header.transmitters)?;
    dict.set_item("receivers", &header.receivers)?;
    dict.set_item("targets", &header.targets)?;
    dict.set_item("ships", &header.ships)?;
    dict.set_item("clocks", &header.clocks)?;
    let origin = header.origin.map(|origin| (origin.lat_deg, origin.lon_deg, origin.h_m));
    dict.set_item("origin", origin)?;
    dict.set_item("seed", header.seed)?;
    dict.set_item("config", &header.config)?;
    dict.set_item("start_time_ns", start_time_ns)?;
    dict.set_item("start_time_frac_ns", start_time_frac_ns)?;
    dict.set_item("first_pulse", header.first_pulse)?;
    dict.set_item("pulses", header.pulses)?;
    dict.set_item("adc_bits", header.adc.map(|adc| adc.bits))?;
    dict.set_item("adc_step", header.adc.map(|adc| adc.step))?;
    dict.set_item("instrument", crate::object(py, &header.instrument)?)?;
    let replica = PyArray1::from_slice(py, &header.replica);
    match header.turns() {
        1 => dict.set_item("replica", replica)?,
        turns => dict.set_item("replica", replica.reshape([turns, header.replica.len() / turns])?)?,
    }
    Ok(dict)
}
