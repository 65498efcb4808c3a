//! The instrument: `[radar]` and what stands below it.

use super::*;

tables! {
    radar "[radar]" "The instrument." {
        CARRIER_HZ "carrier_hz", number("Hz", 1e6, 1e12), Required, "Carrier frequency.";
        SAMPLE_RATE_HZ "sample_rate_hz", number("Hz", 1e3, 1e11), Required, "Complex sample rate; not below the bandwidth, unless there is a dechirp.";
        PRF_HZ "prf_hz", number("Hz", 0.001, 1e9), Means("pri_us is given"), "Pulse repetition frequency. Exactly one of prf_hz and pri_us. A pulse ends before the next one begins.";
        PRI_US "pri_us", Kind::Numbers { unit: "us", least: 1, most: MOST_PRI, min: 1e-3, max: 1e9 }, Means("prf_hz is given"), "Pulse repetition intervals, repeated in turn.";
        WAVEFORM "waveform", Section(&waveform::TABLE), Required, "What is radiated.";
        DECHIRP "dechirp", Section(&dechirp::TABLE), Means("none"), "Dechirp on reception: FMCW and stretch processing.";
        WINDOW "window", Section(&window::TABLE), Required, "When samples are taken.";
        TX_POLARISATION "tx_polarisation", Choice(words::<TxKind>), Word("simultaneous"), "Whether all transmit polarisations leave with every pulse (each with power_w, separated without leakage), or one after the other.";
        TX_SEQUENCE "tx_sequence", Words { least: 1, most: 256, entry: "H, V, R or L" }, Means("the transmit polarisations of the channels, in order of first use"), "Alternating: transmit polarisation of pulse 0, 1, ..., repeated.";
        CHANNELS "channels", Words { least: 1, most: 16, entry: "receive then transmit polarisation, each H, V, R or L" }, Means("[[radar.channel]] is given"), "Polarisation pairs recorded for every receiver and transmitter that it hears, e.g. [\"HH\", \"HV\", \"VH\", \"VV\"]. Exactly one of channels and [[radar.channel]].";
        CHANNEL "channel", Sections(&channel::TABLE), Means("channels is given"), "Channels, row by row.";
        LOSSES_DB "losses_db", number("dB", 0.0, 300.0), default(0.0), "System losses of both ends, before the receiver's noise; a gain belongs to the antennas.";
        ATMOSPHERE_DB_PER_KM "atmosphere_db_per_km", number("dB/km", 0.0, 1000.0), default(0.0), "Atmospheric attenuation, one way.";
        RAIN_MMPH "rain_mmph", number("mm/h", 0.0, 300.0), default(0.0), "Rain along the whole of every path: attenuation by ITU-R P.838-3 (H, V or circular, by the port of each leg) in addition to atmosphere_db_per_km. Carriers from 1 GHz.";
        RAIN_CLUTTER "rain_clutter", Kind::Flag, Flag(false), "Whether the drops return an echo: Rayleigh scattering of the reflectivity 200 R^1.6 (Marshall and Palmer), up to 20 GHz, in the main lobes of both antennas, from the window's own emission. Needs rain_mmph.";
        RAIN_TOP_M "rain_top_m", number("m", 50.0, 20e3), default(3000.0), "rain_clutter: height of the rain's top above the sea. Attenuation does not know it.";
        RAIN_SPREAD_MPS "rain_spread_mps", number("m/s", 0.0, 20.0), default(1.0), "rain_clutter: rms velocity of the drops, each component, about the wind at 10 m and their mean fall: turbulence, shear, unequal falls.";
        NOISE_FIGURE_DB "noise_figure_db", number("dB", 0.0, 100.0), Means("a noiseless receiver"), "Receiver noise figure F: noise of k T0 F per Hz, T0 = 290 K, which includes that of an antenna at T0.";
        FRONT_END "front_end", Section(&front_end::TABLE), Means("an ideal one"), "What is wrong between echo and converter.";
        ADC "adc", Section(&adc::TABLE), Means("floating-point samples"), "Analogue-to-digital converter.";
        CALIBRATION "calibration", Sections(&calibration::TABLE), Means("none"), "Channels with signals known in closed form, behind all others.";
        DIRECT_PATH "direct_path", Kind::Flag, Flag(false), "Whether the direct path from transmitter to receiver is received.";
    }
    waveform "[radar.waveform] and [emitter.waveform]" "What is radiated, at unit amplitude; and each of the waveforms of kind = \"in-turn\"." {
        KIND "kind", Choice(words::<WaveformKind>), Required, "Linear or nonlinear frequency modulation, a plain pulse of the carrier, a phase code, samples of a pulse from a file, steps of frequency or other pulses in turn (docs/waveforms.md), or a continuous signal: noise, television, FM broadcast, a GPS code, a recording, of which every emission radiates the next segment (docs/continuous.md).";
        BANDWIDTH_HZ "bandwidth_hz", above("Hz", 0.0, 1e11), Required, "lfm, nlfm: swept bandwidth; stepped: swept within each step, a plain pulse without it; noise: bandwidth, between points of a quarter of the power density; dvb-t: the channel, 6e6, 7e6 or 8e6.";
        PULSE_S "pulse_s", above("s", 0.0, 10.0), Required, "lfm, nlfm, cw, stepped: pulse length.";
        SWEEP "sweep", Choice(words::<SweepKind>), Word("up"), "lfm, nlfm: direction of the sweep; lfm alone: triangular, up in the first half of the pulse and down in the second.";
        TAPER "taper", Choice(words::<TaperKind>), Word("taylor"), "nlfm: what the power spectrum is over the band; pulse_s times bandwidth_hz is 4 to 20000.";
        SIDELOBE_DB "sidelobe_db", number("dB", 20.0, 60.0), default(35.0), "nlfm with taper = \"taylor\": side lobes below the peak of the compressed pulse.";
        CODE "code", Choice(words::<CodeKind>), Required, "phase-code: the code.";
        CHIPS "chips", count(2, 65536), Required, "phase-code, all but m-sequence: chips; of Barker 2, 3, 4, 5, 7, 11 or 13, of Frank a square, of Golay a power of two.";
        REGISTER "register", count(2, 16), Required, "phase-code with code = \"m-sequence\": stages n of the shift register, for 2^n - 1 chips.";
        CHIP_S "chip_s", above("s", 0.0, 1.0), Required, "phase-code: length of a chip; one over it is the bandwidth, at most the sample rate. The pulse lasts for all chips.";
        CARRIERS "carriers", Choice(words::<DvbTMode>), Word("8k"), "dvb-t: 1705 or 6817 carriers.";
        GUARD "guard", Choice(words::<Guard>), Word("1/4"), "dvb-t: guard interval over the useful part of a symbol.";
        CONSTELLATION "constellation", Choice(words::<Constellation>), Word("64-qam"), "dvb-t: points of the data carriers.";
        DEVIATION_HZ "deviation_hz", number("Hz", 5e3, 2e5), default(75e3), "fm: greatest deviation; twice that plus 106 kHz is the bandwidth, at most the sample rate.";
        PRN "prn", count(1, 32), Required, "gps-l1-ca: number of the satellite's code.";
        SEED "seed", count(0, u64::MAX), Means("0 of the radar, 1, 2, .. of the emitters in their order"), "noise, dvb-t, fm, gps-l1-ca: what it is drawn by. scene.seed does not change it.";
        PATH "path", File, Required, "file: CSV lines re,im without a header; iq-file: samples, I before Q, or .sigmf-meta or .sigmf-data of a SigMF recording.";
        RATE_HZ "rate_hz", number("Hz", 1e3, 1e11), Required, "file, iq-file: sample rate of the file; not of a SigMF recording, whose metadata have it.";
        DATATYPE "datatype", Choice(words::<Datatype>), Means("by the ending of the file"), "iq-file: type of the samples, as SigMF names it; not of a SigMF recording. Endings that are known: cf32, fc32, c64, cfile, cf64, fc64, c128, cs16, sc16, ci16, cs8, sc8, cu8.";
        AFTER "after", Choice(words::<AfterEnd>), Word("repeat"), "iq-file: what follows the last sample.";
        STEPS "steps", count(2, MOST_TURNS), Required, "stepped: pulses, each of its own frequency, in turn.";
        STEP_HZ "step_hz", number("Hz", -1e10, 1e10), Required, "stepped: from the frequency of a pulse to that of the next one, negative if it falls; their middle is carrier_hz. Not 0.";
        WAVEFORMS "waveforms", Sections(&TABLE), Required, "in-turn: 2 to 1024 pulses; emission k radiates number k modulo how many they are.";
        OFFSET_HZ "offset_hz", number("Hz", -5e10, 5e10), default(0.0), "Of a pulse among waveforms: its carrier less that of the radar or emitter.";
        DROOP_DB "droop_db", number("dB", 0.0, 60.0), default(0.0), "How far the amplitude falls, linearly, from the begin of the pulse to its end. Pulses alone, without dechirp.";
    }
    dechirp "[radar.dechirp]" "What is received is multiplied by the conjugate of the waveform, filtered and sampled: an echo becomes a tone (docs/fmcw.md). Needs waveform.kind = \"lfm\", whose bandwidth may then exceed the sample rate." {
        DELAY_US "delay_us", number("us", 0.0, 1e7), Required, "Delay of the reference after the emission, of the length of the pulse: an echo of this delay has the beat frequency 0, one that comes later a negative one where the sweep rises.";
    }
    window "[radar.window]" "The receive window of every receiver without one of its own. Exactly one of start_us and follow; neither with gate = \"continuous\"." {
        SAMPLES "samples", count(1, 1 << 24), Required, "Complex samples per channel, of all receivers; windowed without dechirp: not shorter than the pulse. Continuous: samples of a block.";
        GATE "gate", Choice(words::<GateKind>), Word("windowed"), "Whether receivers take a window after every pulse, or all that comes from the first pulse on, in blocks without a gap (docs/continuous.md).";
        START_US "start_us", number("us", 0.0, 1e7), Means("follow is given"), "Start after the emission, not rounded to the sample grid. May exceed the pulse interval.";
        FOLLOW "follow", Section(&follow::TABLE), Means("start_us is given"), "A window that follows the echo of an aim point.";
    }
    follow "[radar.window.follow] and [receiver.window.follow]" "A window that follows the echo of an aim point, by each receiver's own geometry: that of the first transmitter that it hears. Receivers on one platform are sampled together, by the first of them." {
        KIND "kind", Choice(words::<AimKind>), Required, "A point of the scene, or one beside a platform.";
        POSITION_M "position_m", vector("m", 3, FAR_M), Means("lat_deg and lon_deg are given"), "at: East, North, height above the sea, at pulse 0.";
        LAT_DEG "lat_deg", number("deg", -90.0, 90.0), Means("position_m is given"), "at: latitude; the point lies on the sea.";
        LON_DEG "lon_deg", number("deg", -180.0, 360.0), Means("position_m is given"), "at: longitude.";
        VELOCITY_MPS "velocity_mps", vector("m/s", 3, FAST_MPS), Zeros, "at: velocity East, North, up.";
        PLATFORM "platform", Name, Required, "beside: the platform.";
        ALONG_M "along_m", number("m", -FAR_M, FAR_M), default(0.0), "beside: metres ahead along the ground track.";
        ACROSS_M "across_m", number("m", -FAR_M, FAR_M), Required, "beside: metres to starboard of the ground track, negative to port.";
        LEAD_US "lead_us", number("us", 0.0, 1e6), Required, "How much earlier than the echo of the aim point the window opens.";
        AIM_FROM "aim_from", Choice(words::<AimFrom>), Word("reported"), "Which tracks steer the opening of the receive window.";
    }
    front_end "[radar.front_end]" "What is wrong between echo and converter, for the samples of all receivers, noise included (docs/signal.md). Not beside [[radar.calibration]]." {
        IQ_GAIN_DB "iq_gain_db", number("dB", -20.0, 20.0), default(0.0), "Gain of I over that of Q.";
        IQ_PHASE_DEG "iq_phase_deg", number("deg", -60.0, 60.0), default(0.0), "How far Q is off the quarter turn.";
        OFFSET_DBW "offset_dbw", number("dBW", -400.0, 100.0), Means("none"), "Power of a constant that is added to every sample.";
        OFFSET_PHASE_DEG "offset_phase_deg", number("deg", -360.0, 360.0), default(0.0), "offset_dbw: its phase.";
        STC_FULL_US "stc_full_us", above("us", 0.0, 1e7), Means("no sensitivity time control"), "Sensitivity time control: time after the last emission from which on the gain is full. Not with dechirp, nor with gate = \"continuous\".";
        STC_EXPONENT "stc_exponent", number("", 0.0, 8.0), default(4.0), "stc_full_us: power of the time by which the power gain grows until then.";
        STC_DEPTH_DB "stc_depth_db", number("dB", 0.0, 200.0), default(60.0), "stc_full_us: least gain, below the full one.";
        BLANKING "blanking", Kind::Flag, Flag(false), "Whether samples are 0 while the radar transmits, in channels whose transmitter is on the platform of the receiver. Not with dechirp, nor with gate = \"continuous\".";
        RECOVERY_US "recovery_us", number("us", 0.0, 1e7), default(0.0), "blanking: how much longer than the pulse it lasts.";
        AGC_LEVEL_DBW "agc_level_dbw", number("dBW", -400.0, 100.0), Means("no automatic gain control"), "Automatic gain control within the window of each pulse: mean power of samples above which the gain falls. Not with gate = \"continuous\".";
        AGC_ATTACK_US "agc_attack_us", above("us", 0.0, 1e7), default(1.0), "agc_level_dbw: time constant of the mean where the power rises.";
        AGC_RELEASE_US "agc_release_us", above("us", 0.0, 1e7), default(10.0), "agc_level_dbw: time constant where it falls.";
        AGC_DEPTH_DB "agc_depth_db", number("dB", 0.0, 200.0), default(60.0), "agc_level_dbw: least gain, below the full one.";
        TX_LEVEL_RMS_DB "tx_level_rms_db", number("dB", 0.0, 6.0), default(0.0), "Instability of the transmitters from pulse to pulse, before noise: level, standard deviation. Not with gate = \"continuous\", nor where a window receives other pulses than its own.";
        TX_PHASE_RMS_DEG "tx_phase_rms_deg", number("deg", 0.0, 60.0), default(0.0), "The same: phase, standard deviation.";
        JITTER_RMS_S "jitter_rms_s", number("s", 0.0, 1e-3), default(0.0), "Jitter of the sampling clock, from sample to sample: standard deviation. 2 pi times it times the highest frequency is at most 0.3.";
        JITTER_IF_HZ "jitter_if_hz", number("Hz", 0.0, 1e12), default(0.0), "jitter_rms_s: intermediate frequency at which the converter meets the carrier.";
    }
    adc "[radar.adc]" "Analogue-to-digital converter: mid-rise, I and Q separately, saturating." {
        BITS "bits", count(1, 16), Required, "Bits.";
        FULL_SCALE_DBW "full_scale_dbw", number("dBW", -400.0, 200.0), Required, "Full scale of I and of Q: 20 log10 of the amplitude in sqrt(W). A tone of this power just fills I and Q.";
    }
    channel "[[radar.channel]]" "One recorded channel." {
        POLARISATION "polarisation", PolarisationPair, Required, "Receive then transmit polarisation, e.g. \"HV\".";
        TRANSMITTER "transmitter", Name, Means("the only transmitter"), "Its transmitter.";
        RECEIVER "receiver", Name, Means("the only receiver"), "Its receiver.";
        NAME "name", Name, Means("the polarisation pair, with the names of the antennas where there are several"), "Its name in recordings.";
    }
    calibration "[[radar.calibration]]" "A channel that carries a signal known in closed form in place of an echo (docs/calibration.md)." {
        NAME "name", Name, Required, "Its name in recordings, unique among channels.";
        KIND "kind", Choice(words::<SignalKind>), Required, "A continuous tone, or the transmitted pulse after the receive filter.";
        RECEIVER "receiver", Name, Means("the only receiver"), "The receiver that takes it, with its clock.";
        TRANSMITTER "transmitter", Name, Means("the only transmitter"), "loopback: the transmitter, with its clock.";
        POWER_DBW "power_dbw", number("dBW", -400.0, 200.0), Required, "Power of the signal; of a loopback, that of a pulse of unit amplitude.";
        PHASE_DEG "phase_deg", number("deg", -360.0, 360.0), default(0.0), "Its phase: of a tone at the emission of pulse 0.";
        OFFSET_HZ "offset_hz", number("Hz", -5e10, 5e10), Required, "tone: frequency above the carrier, at most half the sample rate either way.";
        DELAY_S "delay_s", number("s", 0.0, 100.0), Required, "loopback: from the first sample of every window to the begin of the pulse; the whole pulse must lie in the window.";
        NOISE "noise", Kind::Flag, Flag(false), "Whether the receiver's noise is added.";
    }
}
