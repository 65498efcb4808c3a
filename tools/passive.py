"""Targets of a passive radar: cross-ambiguity of a surveillance channel with a reference channel.

    python3 tools/passive.py passive.h5

The recording is that of configs/passive.toml: blocks without a gap, channel 0 looks at the transmitter, channel 1 at
the sea. chi(tau, f) = sum_n s(n) r*(n - tau) exp(-j 2 pi f n), in batches of one block: correlated over delay by an
FFT, then an FFT from batch to batch. Needs numpy and h5py.
"""

import sys

import h5py
import numpy as np

C_MPS = 299_792_458.0
CELLS = 400  # of delay


def cross_ambiguity(reference, surveillance):
    """|chi|^2 [Doppler, delay] of two arrays [block, sample]; Doppler in the order of np.fft.fftfreq."""
    samples = reference.shape[1]
    length = 2 * samples
    spectra = np.fft.fft(surveillance, length) * np.conj(np.fft.fft(reference, length))
    delays = np.fft.ifft(spectra)[:, :CELLS]
    taper = np.hanning(len(delays))[:, None]
    return np.abs(np.fft.fft(delays * taper, axis=0)) ** 2


def between(left, middle, right):
    """Where the parabola through three values of a peak has its top, -0.5 to 0.5."""
    return 0.5 * (left - right) / (left - 2 * middle + right)


def peaks(chi, count):
    """Strongest cells off zero Doppler: [Doppler cell, delay cell], between cells."""
    power, half = chi.copy(), len(chi) // 2
    power[np.r_[0:4, -3:0]] = 0.0  # direct path, and the sea, whose Bragg lines lie at 2 Hz
    for _ in range(count):
        m, n = np.unravel_index(power[:, 1:-1].argmax(), power[:, 1:-1].shape)
        n += 1
        if power[m, n] == 0.0:
            return
        log = np.log(chi)
        row = m + between(*log[[m - 1, m, (m + 1) % len(chi)], n])
        column = n + between(*log[m, n - 1 : n + 2])
        yield (row + half) % len(chi) - half, column
        power[np.arange(m - 4, m + 5) % len(chi), max(n - 4, 0) : n + 5] = 0.0


def main(path):
    with h5py.File(path) as file:
        iq, rate_hz = file["iq"][:], file.attrs["sample_rate_hz"]
        delay_s, doppler_hz = (file[f"truth/{name}"][:, 1].mean(axis=0) for name in ("delay_s", "doppler_hz"))
        names = [name.decode() if isinstance(name, bytes) else str(name) for name in file["truth/targets"][:]]
        tower, station = (file[f"nav/{name}/phase_centre_m"][0] for name in ("tv", "reference"))
    chi = cross_ambiguity(iq[:, 0], iq[:, 1])
    direct_s = np.linalg.norm(tower - station) / C_MPS
    cell_hz = rate_hz / iq.shape[2] / len(iq)
    found = [(row * cell_hz, column / rate_hz + direct_s) for row, column in peaks(chi, len(names))]
    if not found:
        sys.exit(f"{path}: {len(iq)} blocks are too few to tell what moves from what rests")
    for name, tau_s, f_hz in zip(names, delay_s, doppler_hz, strict=True):
        hz, s = min(found, key=lambda peak: abs(peak[0] - f_hz) / cell_hz + abs(peak[1] - tau_s) * rate_hz)
        off = (abs(hz - f_hz) / cell_hz, abs(s - tau_s) * rate_hz)
        print(f"{name}: {hz:.2f} Hz and {1e6 * s:.4f} us, off by {off[0]:.2f} and {off[1]:.2f} cells")


if __name__ == "__main__":
    main(sys.argv[1])
