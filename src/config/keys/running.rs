//! How echoes are made, released and kept.

use super::*;
use crate::pulse::flags::MOST_CLASS;

tables! {
    fidelity "[fidelity]" "Speed against accuracy." {
        ECHO "echo", Choice(words::<EchoKind>), Word("fast"), "reference: every pulse from its own scatterer paths, in f64. fast: blocks of pulses, paths at nodes and interpolated between them, in f32.";
        ERROR_DB "error_db", number("dB", -120.0, -20.0), default(-60.0), "fast: error allowed against the reference, worst pulse and channel. The keys below are chosen to keep it, but for those that are given.";
        NODE_PULSES "node_pulses", count(1, 341), Means("chosen for error_db"), "fast: pulses from one instant at which surface and paths are found to the next; 1: every pulse by itself, from exact paths.";
        SCATTER_PULSES "scatter_pulses", count(1, 341), Means("chosen for error_db"), "fast: pulses from one instant at which scattering is found to the next: node_pulses, or about half or a third of it.";
        GAIN_PULSES "gain_pulses", count(1, 341), Means("chosen for error_db"), "fast: pulses from one instant at which antenna gains are found to the next.";
        PANEL_PULSES "panel_pulses", count(1, 341), Means("chosen for error_db"), "fast: pulses from one instant at which the panels of ships are evaluated to the next.";
        SIDELOBE_DB "sidelobe_db", number("dB", -400.0, 0.0), Means("chosen for error_db"), "fast: two-way gain below the peak of its antennas at which a tile of 16 x 16 facets is evaluated less often: paths and scattering at the ends of a block only (scattering in its middle, too, where facets turn away), gains at two thirds of the instants; -400: none is.";
        CUTOFF_DB "cutoff_db", number("dB", -400.0, 0.0), Means("chosen for error_db"), "fast: two-way gain below the peak of its antennas at which a tile of 16 x 16 facets is left out, where there are sidelobe tiles; -400: none is.";
        KERNEL_WIDTH "kernel_width", count(2, 8), Means("chosen for error_db"), "fast: cells over which a path is spread; about 20 dB per cell.";
        DOPPLER "doppler", Choice(words::<Doppler>), Means("chosen for error_db"), "fast: Doppler within a pulse by its mean; to first order; by a shift of delay, alone or with what that leaves to first order (linear sweeps).";
    }
    stream "[stream]" "How pulses are released." {
        PACE "pace", Choice(words::<Pace>), Word("realtime"), "At their emission times plus the latency, or as soon as they are made.";
        POLICY "policy", Choice(words::<Policy>), Word("stop"), "When pulses are overdue, because generation cannot keep up or the machine stood still: end with an error, stretch time, drop pulses, or make the next ones at a coarser error (docs/running.md).";
        RELAX_DB "relax_db", Kind::Numbers { unit: "dB", least: 1, most: MOST_CLASS as usize, min: -120.0, max: -20.0 }, Means("15 and 30 above fidelity.error_db, as far as -20"), "relax: errors at which pulses may be made while generation falls behind, from fine to coarse, all above fidelity.error_db.";
        LATENCY_MS "latency_ms", number("ms", 1.0, 60_000.0), Means("500; with live navigation what its interpolation needs at the rate of its fixes, at least 500; with policy relax twice what is made at once, at least 500"), "Release minus emission time: how far ahead pulses are made.";
        PACER_PRIORITY "pacer_priority", Choice(words::<PacerAhead>), Word("realtime"), "Whether the thread that releases pulses runs at real-time priority (SCHED_FIFO), where the system allows that and there are at most 1000 pulses/s; `nereus run` reports it, or why not.";
        PACER_CORE "pacer_core", count(0, 1023), Means("any"), "The core on which the thread that releases pulses asks to stay.";
        LOCK_MEMORY "lock_memory", Kind::Flag, Absent::Flag(false), "Whether the stream asks the system that its memory is never moved out (mlockall).";
        MONITOR "monitor", Kind::Address, Means("none"), "Serve a live page there, as `nereus run --monitor` does (docs/monitor.md), such as 127.0.0.1:8080.";
        THREADS "threads", count(0, 1024), Count(0), "Threads that make pulses; 0: as many as the machine has.";
    }
    sink "[[sink]]" "A place where pulses go." {
        KIND "kind", Choice(words::<SinkKind>), Required, "HDF5 recording; folder of plain files; CRSD 1.0 (docs/formats.md); VITA 49.2 over UDP (docs/wire.md); radar video over UDP (docs/asterix.md); shared memory and ZeroMQ (docs/formats.md); what a platform reports, on a port (docs/navigation.md); what a radar and AIS report of targets, on a port (docs/asterix.md); nowhere.";
        PATH "path", Output, Required, "hdf5, crsd: the file; plain: the folder.";
        SEGMENT_S "segment_s", number("s", 0.1, 1e7), Means("one file"), "hdf5: start a new file every so many seconds.";
        ADDRESS "address", Kind::Address, Means("vita49: \"127.0.0.1:4991\"; asterix: \"127.0.0.1:8600\""), "vita49, asterix: the receiver; asterix: or a group of IPv4. Nothing leaves the machine unless this names another one, or interface one of its own.";
        BIND "bind", Kind::Address, Means("vita49: any free port; zmq: \"127.0.0.1:5555\""), "vita49: local address and port to send from. zmq: where subscribers connect to; with messages = \"samples\" channel 0 has this port, and each other channel the one after that of the channel before.";
        MESSAGES "messages", Choice(words::<Messages>), Word("samples"), "zmq: samples of a channel alone, complex64, a port for each channel (GNU Radio's ZMQ SUB source); or topic, JSON header and all channels on one port.";
        SERVICE "service", Name, Word("nereus"), "shm: first part of the names of its iceoryx2 services.";
        SUBSCRIBERS "subscribers", count(1, 64), Count(4), "shm: most subscribers at a time.";
        BUFFER_PULSES "buffer_pulses", count(1, 65_536), Means("one second of pulses, at least 64, at most 65536 or 32 MiB"), "shm, zmq: pulses that may wait for a subscriber. While as many wait it loses pulses: of shared memory the oldest, of ZeroMQ those that come.";
        MTU_BYTES "mtu_bytes", count(576, 65_535), Count(1500), "vita49, asterix: greatest IP packet; pulses are split to fit, radials of video by range.";
        PROFILE "profile", Choice(words::<Profile>), Word("nereus"), "vita49: all packets of docs/wire.md, or those of DIFI (IEEE-ISTO 4900) alone: samples and contexts of each channel. difi needs radar.adc.";
        INTERFACE "interface", Kind::Interface, Means("\"127.0.0.1\""), "asterix, address of a group: by which interface datagrams leave.";
        TTL_HOPS "ttl_hops", count(1, 255), Count(1), "asterix, address of a group: hops that datagrams may go; 1: they stay in the network of the interface.";
        SAC "sac", count(0, 255), Count(0), "asterix: system area code.";
        SIC "sic", count(0, 255), Count(1), "asterix: system identification code.";
        CHANNEL "channel", Name, Means("the first that scans"), "asterix: the channel. Its transmitter and receiver are on one platform, and the receiver scans.";
        CELL_M "cell_m", above("m", 0.0, 1e5), Means("that of a sample, c/2 over radar.sample_rate_hz"), "asterix: range of a cell, at least half of that of a sample.";
        CELL "cell", Choice(words::<CellValue>), Word("peak"), "asterix: greatest or mean power of what lies in a cell.";
        RADIAL_PULSES "radial_pulses", count(1, 1024), Count(1), "asterix: pulses whose mean power is sent as one radial.";
        BITS "bits", Kind::OneOf(&Bits::ALLOWED), Count(8), "asterix: bits of a cell.";
        DETECTION "detection", Choice(words::<DetectionKind>), Word("log"), "asterix: code by the logarithm of the power, or by its root.";
        FULL_DBW "full_dbw", number("dBW", -300.0, 100.0), Means("log: 70 dB above the noise of the receiver behind the compression; linear: so that this noise is 4 codes"), "asterix: level of the greatest code, that of the echo before compression.";
        DYNAMIC_DB "dynamic_db", number("dB", 1.0, 300.0), default(80.0), "asterix, log: level of the greatest code over that of code 0.";
        DEVICE "device", Output, Required, "nav, targets: the path of a serial port or pseudo terminal, file:PATH, tcp://ADDRESS:PORT (somebody who listens there), or udp://ADDRESS:PORT.";
        BAUD "baud", count(50, 4_000_000), Count(115_200), "nav, targets, serial port: bits per second.";
        PLATFORM "platform", Name, Means("the only platform"), "nav: the platform; targets: own ship, or the mast of a station.";
        FORMAT "format", Choice(words::<NavFormat>), Word("nmea"), "nav: NMEA 0183; NovAtel INSPVAX, ASCII or binary.";
        SENTENCES "sentences", Words { least: 1, most: 7, entry: "GGA, RMC, VTG, HDT, ZDA, GST or PASHR" }, Means("[\"GGA\", \"RMC\"]"), "nav, nmea: sentences, in this order. Readers such as gpsd expect GGA, then RMC, and others behind.";
        TARGET_SENTENCES "target_sentences", Words { least: 1, most: 4, entry: "TTM, TLL, RSD or VDM" }, Means("[\"TTM\", \"TLL\", \"VDM\"]"), "targets: sentences, in this order: tracked targets, their positions, radar system data, AIS of the ships.";
        OWN_SHIP "own_ship", Choice(words::<AimFrom>), Word("reported"), "targets: whether the radar measures by what own ship reports, errors included, or by the truth.";
        RATE_HZ "rate_hz", above("Hz", 0.0, 1000.0), Means("nav: 5; targets: 1"), "nav, targets: messages per second, at most one per pulse (targets: about each).";
        LATENCY_S "latency_s", number("s", 0.0, 10.0), default(0.0), "nav, targets: how much later than its emission time a message leaves, in emission time.";
        QUEUE_PULSES "queue_pulses", count(1, 1 << 20), Means("two seconds of pulses, at least 64, at most 65536 or 256 MiB"), "Pulses that may wait for this sink.";
        ON_FAILURE "on_failure", Choice(words::<OnFailure>), Word("stop"), "When this sink fails (a full disk): end the run, or go on for the other sinks and fail at its end (docs/running.md).";
    }
}
