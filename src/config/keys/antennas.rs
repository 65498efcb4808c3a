//! Transmitters and receivers, their antennas and clocks.

use super::*;

tables! {
    transmitter "[[transmitter]]" "An antenna that radiates." {
        NAME "name", Name, Required, "Its name, unique among transmitters and receivers.";
        PLATFORM "platform", Name, Required, "The platform that carries it.";
        POWER_W "power_w", above("W", 0.0, 1e12), Required, "Peak power per polarisation: two simultaneous ones radiate twice as much.";
        LEVER_ARM_M "lever_arm_m", vector("m", 3, 1e4), Zeros, "Phase centre: forward, starboard, down from the platform's reference.";
        ANTENNA "antenna", Section(&antenna::TABLE), Required, "Gain pattern.";
        POINTING "pointing", Section(&pointing::TABLE), Means("fixed, all angles 0: along the nose"), "Where it points.";
        CROSS_POL_ISOLATION_DB "cross_pol_isolation_db", number("dB", 0.0, 200.0), Means("ideal ports"), "Leakage of the orthogonal port, dB below the wanted one.";
        CLOCK "clock", Section(&clock::TABLE), Means("an ideal clock"), "Errors of its clock.";
    }
    receiver "[[receiver]]" "An antenna that receives." {
        NAME "name", Name, Required, "Its name, unique among transmitters and receivers.";
        PLATFORM "platform", Name, Required, "The platform that carries it.";
        LEVER_ARM_M "lever_arm_m", vector("m", 3, 1e4), Zeros, "Phase centre: forward, starboard, down from the platform's reference.";
        ANTENNA "antenna", Section(&antenna::TABLE), Required, "Gain pattern.";
        POINTING "pointing", Section(&pointing::TABLE), Means("fixed, all angles 0: along the nose"), "Where it points.";
        CROSS_POL_ISOLATION_DB "cross_pol_isolation_db", number("dB", 0.0, 200.0), Means("ideal ports"), "Leakage of the orthogonal port, dB below the wanted one.";
        CLOCK "clock", Section(&clock::TABLE), Means("an ideal clock"), "Errors of its clock.";
        HEARS "hears", Words { least: 0, most: 256, entry: "the name of a transmitter" }, Means("all transmitters"), "Transmitters whose echoes it records, at least one: it has channels with these alone.";
        GAIN_DB "gain_db", number("dB", -60.0, 60.0), default(0.0), "Gain of its echoes, before the receiver's noise: an imbalance of channels, or what a cable loses.";
        PHASE_DEG "phase_deg", number("deg", -360.0, 360.0), default(0.0), "Phase of its echoes.";
        ARRAY "array", Section(&array::TABLE), Means("one antenna"), "An array of such antennas, each a receiver of its own (docs/arrays.md).";
        WINDOW "window", Section(&own_window::TABLE), Means("that of [radar.window]"), "Where its window starts, with as many samples as that of [radar.window].";
    }
    emitter "[[emitter]]" "What else radiates: another radar, a beacon, a jammer, with a carrier, a waveform and a schedule of its own. What receivers take of it is added to their channels (docs/emitters.md). Exactly one of prf_hz and pri_us." {
        NAME "name", Name, Required, "Its name, unique among antennas.";
        PLATFORM "platform", Name, Required, "The platform that carries it.";
        POWER_W "power_w", above("W", 0.0, 1e12), Required, "Peak power.";
        LEVER_ARM_M "lever_arm_m", vector("m", 3, 1e4), Zeros, "Phase centre: forward, starboard, down from the platform's reference.";
        ANTENNA "antenna", Section(&antenna::TABLE), Required, "Gain pattern.";
        POINTING "pointing", Section(&pointing::TABLE), Means("fixed, all angles 0: along the nose"), "Where it points.";
        CROSS_POL_ISOLATION_DB "cross_pol_isolation_db", number("dB", 0.0, 200.0), Means("ideal ports"), "Leakage of the orthogonal port, dB below the wanted one.";
        CARRIER_HZ "carrier_hz", number("Hz", 1e6, 1e12), Means("that of [radar]"), "Carrier frequency. A part of its band must lie within half the sample rate of that of [radar].";
        PRF_HZ "prf_hz", number("Hz", 0.001, 1e9), Means("pri_us is given"), "Its pulses a second; the first leaves with pulse 0 or as start_us says, the last before the last window closes.";
        PRI_US "pri_us", Kind::Numbers { unit: "us", least: 1, most: 65_536, min: 1e-3, max: 1e9 }, Means("prf_hz is given"), "Its intervals in turn.";
        START_US "start_us", number("us", -1e9, 1e9), default(0.0), "Its first pulse minus pulse 0 of the radar; below 0 the first windows receive what was under way.";
        WAVEFORM "waveform", Section(&waveform::TABLE), Required, "What it radiates; it may be wider than the sample rate.";
        POLARISATION "polarisation", Choice(words::<Polarisation>), Word("H"), "Polarisation of all its pulses.";
        HEARD_BY "heard_by", Words { least: 1, most: 256, entry: "the name of a receiver" }, Means("all receivers"), "Receivers that take it.";
        DIRECT_PATH "direct_path", Kind::Flag, Flag(true), "Whether its direct path is received.";
        ECHO "echo", Kind::Flag, Flag(true), "Whether sea, ships and targets return it; rain does not.";
    }
    array "[receiver.array]" "Equal antennas in a row: receivers NAME-0, NAME-1, .. that share platform, pattern, pointing, window and clock." {
        ELEMENTS "elements", count(2, 64), Required, "How many.";
        SPACING_M "spacing_m", vector("m", 3, 1e4), Required, "From the phase centre of one to that of the next: forward, starboard, down. The middle of all lies at lever_arm_m.";
        GAINS_DB "gains_db", Kind::Numbers { unit: "dB", least: 2, most: 64, min: -60.0, max: 60.0 }, Means("0 dB of all"), "Errors of the gain, element by element, besides gain_db.";
        PHASES_DEG "phases_deg", Kind::Numbers { unit: "deg", least: 2, most: 64, min: -360.0, max: 360.0 }, Means("0 of all"), "Errors of the phase, element by element, besides phase_deg.";
    }
    own_window "[receiver.window]" "Where the window of a receiver starts. Exactly one of start_us and follow." {
        START_US "start_us", number("us", 0.0, 1e7), Means("follow is given"), "Start after the emission, not rounded to the sample grid. May exceed the pulse interval.";
        FOLLOW "follow", Section(&follow::TABLE), Means("start_us is given"), "A window that follows the echo of an aim point.";
    }
    antenna "antenna = { ... } of [[transmitter]], [[receiver]] and [[emitter]]" "A gain pattern. Boresight +x, width along +y (horizontal), height along +z." {
        KIND "kind", Choice(words::<PatternKind>), Required, "Kind of aperture, uniformly illuminated unless tapered. Ports H and V: of isotropic antennas level at the phase centre wherever they point, of all others Ludwig's third definition about the boresight (docs/polarisation.md).";
        GAIN_DBI "gain_dbi", number("dBi", -200.0, 200.0), default(0.0), "isotropic: gain in every direction.";
        WIDTH_M "width_m", above("m", 0.0, 1e4), Required, "rectangle, ellipse: full width.";
        HEIGHT_M "height_m", above("m", 0.0, 1e4), Required, "rectangle, ellipse: full height.";
        TAPER "taper", Choice(words::<ApertureTaperKind>), Word("uniform"), "rectangle: how the illumination falls along the width; side lobes of -13, -23, -43 dB, and as sidelobe_db says.";
        HEIGHT_TAPER "height_taper", Choice(words::<ApertureTaperKind>), Word("uniform"), "rectangle: the same along the height.";
        SIDELOBE_DB "sidelobe_db", number("dB", 20.0, 50.0), default(30.0), "rectangle with a taper of \"taylor\": side lobes below the peak.";
        DIAMETER_M "diameter_m", above("m", 0.0, 1e4), Required, "circle: diameter.";
        PATH "path", File, Required, "file: CSV, columns az_deg,el_deg,gain_dbi[,phase_deg] on a regular grid; azimuth positive to the left of the boresight (+y), elevation positive up. Or two cuts of Planet (.msi, .pln, .pla), or cuts of GRASP (.cut): docs/scanning.md#measured-patterns.";
        FLOOR_DBI "floor_dbi", number("dBi", -400.0, 200.0), default(-60.0), "file: gain outside the grid.";
    }
    clock "[transmitter.clock] and [receiver.clock]" "Clock error: reading minus the time of the run. Delays and phases are those of the difference of both ends." {
        SAME_AS "same_as", Name, Means("a clock of its own"), "The antenna, written above, whose clock it shares; other keys are not allowed then.";
        OFFSET_S "offset_s", number("s", -1.0, 1.0), default(0.0), "Reading minus time at pulse 0.";
        DRIFT "drift", number("", -1e-3, 1e-3), default(0.0), "Fractional frequency at pulse 0: 1e-9 gains a nanosecond a second.";
        AGEING_PER_DAY "ageing_per_day", number("1/day", -1e-3, 1e-3), default(0.0), "Growth of the fractional frequency in a day.";
        PRESET "preset", Choice(words::<Oscillator>), Means("no noise but that of noise_h"), "Noise of a kind of oscillator, Allan deviation at 1 s: 2e-12 and 1e-9 (flicker), 1e-11 and 2e-11 (white frequency).";
        NOISE_H "noise_h", Kind::Numbers { unit: "", least: 5, most: 5, min: 0.0, max: 1.0 }, Means("that of the preset, or none"), "h_-2, h_-1, h_0, h_1, h_2 of the one-sided spectrum of the fractional frequency, S_y(f) = sum of h_a f^a (1/Hz).";
        BANDWIDTH_HZ "bandwidth_hz", above("Hz", 0.0, 1e9), Means("half the pulse rate"), "Highest frequency of the phase noise of h_1 and h_2.";
    }
    pointing "pointing = { ... } of [[transmitter]], [[receiver]] and [[emitter]]" "Where an antenna points." {
        KIND "kind", Choice(words::<Servo>), Required, "Bolted to the body; servo on a point; servo on a point beside a platform; a pedestal that turns without end; one that goes to and fro; a beam that stays in each of some directions for some pulses.";
        YAW_DEG "yaw_deg", number("deg", -360.0, 360.0), default(0.0), "fixed: relative to the body, positive to starboard (clockwise from above).";
        PITCH_DEG "pitch_deg", number("deg", -90.0, 90.0), default(0.0), "fixed: relative to the body, positive up.";
        ROLL_DEG "roll_deg", number("deg", -180.0, 180.0), default(0.0), "fixed: about the boresight.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given"), "at: East, North, height above the sea, at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "at: latitude; the point lies on the sea.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "at: longitude.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "at: velocity East, North, up.";
        PLATFORM "platform", Name, Required, "beside: the platform.";
        ALONG_M "along_m", number("m", -FAR_M, FAR_M), default(0.0), "beside: metres ahead along the ground track.";
        ACROSS_M "across_m", number("m", -FAR_M, FAR_M), Required, "beside: metres to starboard of the ground track, negative to port.";
        AIM_FROM "aim_from", Choice(words::<AimFrom>), Word("reported"), "at, beside: which tracks the servo knows; scan, sector, steps from north: by which the pedestal or beam is kept level.";
        ABOUT "about", Choice(words::<ScanFrom>), Word("nose"), "scan, sector, steps: azimuth and elevation from the platform's nose and deck, or from the scene's North and the horizontal plane.";
        RPM "rpm", number("1/min", -600.0, 600.0), Required, "scan: turns a minute, clockwise seen from above; negative: counterclockwise.";
        START_DEG "start_deg", number("deg", -360.0, 360.0), default(0.0), "scan: azimuth at pulse 0, clockwise.";
        ELEVATION_DEG "elevation_deg", number("deg", -90.0, 90.0), default(0.0), "scan: elevation of the boresight, positive up.";
        FROM_DEG "from_deg", number("deg", -360.0, 360.0), Required, "sector: azimuth at which sweeps of even number begin, the first at pulse 0, clockwise.";
        TO_DEG "to_deg", number("deg", -360.0, 360.0), Required, "sector: azimuth at which they end, other than from_deg.";
        RATE_DEG_S "rate_degps", above("deg/s", 0.0, 3600.0), Required, "sector: rate within a sweep.";
        TURN_MS "turn_ms", number("ms", 1.0, 1e5), default(100.0), "sector: time in which the pedestal turns round between sweeps, past either end by a quarter of rate times time.";
        ELEVATIONS_DEG "elevations_deg", Kind::Numbers { unit: "deg", least: 1, most: 1024, min: -90.0, max: 90.0 }, Means("[0], the horizontal plane or the deck"), "sector: elevations of sweeps in turn, positive up: a raster; steps: of each direction, or one for all.";
        AZIMUTHS_DEG "azimuths_deg", Kind::Numbers { unit: "deg", least: 1, most: 1024, min: -360.0, max: 360.0 }, Required, "steps: azimuths of the directions in turn, clockwise; the first at pulse 0.";
        DWELL_PULSES "dwell_pulses", Kind::Count { min: 1, max: 1_000_000 }, Required, "steps: pulses in each direction; with intervals in turn, a multiple of their number.";
        ENCODER_BIAS_DEG "encoder_bias_deg", number("deg", -180.0, 180.0), default(0.0), "scan, sector, steps: azimuth that the encoder reads minus the azimuth.";
        ENCODER_NOISE_DEG "encoder_noise_deg", number("deg", 0.0, 10.0), default(0.0), "scan, sector, steps: noise of each reading of azimuth and elevation, rms.";
        ENCODER_BITS "encoder_bits", Kind::Count { min: 4, max: 30 }, Means("no steps"), "scan, sector, steps: bits of a turn to which readings are rounded.";
        LAG_S "lag_s", number("s", 0.0, 100.0), default(0.0), "at, beside: the servo acts on what was known this long ago.";
        BIAS_AZ_DEG "bias_az_deg", number("deg", -180.0, 180.0), default(0.0), "at, beside: constant azimuth offset of the boresight, positive to the left (+y of the antenna), opposite to yaw_deg.";
        BIAS_EL_DEG "bias_el_deg", number("deg", -90.0, 90.0), default(0.0), "at, beside: constant elevation offset of the boresight, positive up (+z of the antenna).";
    }
}
