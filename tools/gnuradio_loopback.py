"""The flowgraph of tools/gnuradio: gnuradio_loopback.py NEREUS FOLDER

ZMQ SUB source -> vectors of a window -> FFT -> times the conjugate spectrum of the replica -> inverse FFT: the correlation of
every pulse with the transmitted one. Its peak must lie at the delay that the scenario has.
"""
import json
import socket
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
from gnuradio import blocks, fft, gr, zeromq

PULSES = 200
# Steps a sample in which the peak is looked for.
FINE = 32


def free_ports(count):
    """The first of so many ports in a row that nobody has."""
    for first in range(25_000, 60_000, count):
        sockets = [socket.socket() for _ in range(count)]
        try:
            for place, each in enumerate(sockets):
                each.bind(("127.0.0.1", first + place))
            return first
        except OSError:
            continue
        finally:
            for each in sockets:
                each.close()
    raise SystemExit("gnuradio_loopback.py: no free ports")


class Correlator(gr.top_block):
    """Correlates every window of a channel with a replica."""

    def __init__(self, port, samples, replica):
        super().__init__("nereus loopback")
        spectrum = np.fft.fft(replica, samples)
        window = fft.window.rectangular(samples)
        chain = [
            # Nothing but samples in a message: no key, no tags.
            zeromq.sub_source(gr.sizeof_gr_complex, 1, f"tcp://127.0.0.1:{port}", 100, False, -1, ""),
            blocks.stream_to_vector(gr.sizeof_gr_complex, samples),
            blocks.head(gr.sizeof_gr_complex * samples, PULSES),
            fft.fft_vcc(samples, True, window, False, 1),
            blocks.multiply_const_vcc(np.conj(spectrum).tolist()),
            fft.fft_vcc(samples, False, window, False, 1),
        ]
        self.connect(*chain)
        self.result = blocks.vector_sink_c(samples)
        self.connect(chain[-1], self.result)

    def correlations(self):
        """[pulse, sample]."""
        data = np.array(self.result.data())
        return data.reshape(-1, data.size // PULSES) if data.size else data


def main():
    nereus, folder = sys.argv[1], Path(sys.argv[2])
    scene = Path(__file__).parent.parent / "configs/selftest.toml"
    text = tomllib.loads(scene.read_text())
    rate_hz, samples = text["radar"]["sample_rate_hz"], text["radar"]["window"]["samples"]
    names = text["radar"]["channels"] + [known["name"] for known in text["radar"]["calibration"]]
    place = names.index("loopback")
    known = next(known for known in text["radar"]["calibration"] if known["name"] == "loopback")
    words = [nereus, "run", str(scene), "--json", "--pace", "realtime"]
    # The replica, from a recording of one pulse.
    once = ["--pulses", "0..1", "--set", "sink=[{ kind = 'plain', path = '%s' }]" % (folder / "once")]
    subprocess.run([*words, *once], check=True, capture_output=True)
    replica = np.fromfile(folder / "once/replica.bin", np.complex64)

    first = free_ports(len(names))
    flowgraph = Correlator(first + place, samples, replica)
    flowgraph.start()
    sink = "sink=[{ kind = 'zmq', bind = '127.0.0.1:%d' }]" % first
    run = subprocess.run([*words, "--set", sink], check=True, capture_output=True, text=True)
    flowgraph.wait()
    report = json.loads(run.stdout.splitlines()[-1])["out"][0]["subscribers"]

    found = flowgraph.correlations()
    assert found.shape == (PULSES, samples), found.shape
    # Between samples by their spectrum, padded.
    spectra = np.fft.fft(found.mean(axis=0))
    padded = np.zeros(samples * FINE, complex)
    padded[: samples // 2], padded[-samples // 2 :] = spectra[: samples // 2], spectra[samples // 2 :]
    peak = int(np.argmax(np.abs(np.fft.ifft(padded)))) / FINE
    expected = known["delay_s"] * rate_hz
    print(f"GNU Radio {gr.version()}: {PULSES} pulses, peak at {peak:.3f} samples, loopback at {expected:.3f}; {report}")
    # Half a step, and the noise of the receiver over 200 pulses, far below it.
    assert abs(peak - expected) <= 0.5 / FINE + 1e-3, (peak, expected)
    # Every pulse by itself, to the nearest sample: none is shifted, none is torn.
    peaks = np.argmax(np.abs(found), axis=1)
    assert np.all(peaks == round(expected)), peaks
    assert report["seen"] == 1, report


if __name__ == "__main__":
    main()
