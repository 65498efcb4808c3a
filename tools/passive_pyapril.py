"""Targets of a passive radar as pyAPRiL finds them, a public library of passive radar that knows nothing of nereus.

    python3 tools/passive_pyapril.py passive.h5

`tools/pyapril` installs what it needs, makes the recording and runs it.

The recording is that of configs/passive.toml: channel 0 looks at the transmitter, channel 1 at the sea. The library's
chain, unmodified: Wiener_SMI cancels the direct path, cc_detector_ons correlates over delay and Doppler, CA_CFAR detects.
Each target of the truth must be the strongest detection within a cell of where it is. Needs numpy, scipy and h5py too.
"""

import sys

import h5py
import numpy as np
from pyapril.caCfar import CA_CFAR
from pyapril.clutterCancellation import Wiener_SMI
from pyapril.detector import cc_detector_ons

C_MPS = 299_792_458.0
FILTER_TAPS = 16  # 2 us of direct path and what lies close to it
DELAYS = 200  # 25 us beyond the direct path
DOPPLER_HZ = 60.0
MARGIN_DB = 15.0
RESTS_HZ = 10.0  # the sea, whose Bragg lines lie at 2 Hz, is two cells of 5 Hz wide


def detections(reference, surveillance, rate_hz):
    """Doppler (Hz), delay beyond the direct path (s) and level over the surroundings (dB), the strongest first."""
    moving, _ = Wiener_SMI(reference, surveillance, FILTER_TAPS, imp="direct_matrix")
    matrix = cc_detector_ons(reference, moving, rate_hz, DOPPLER_HZ, DELAYS)
    hits, over_noise = CA_CFAR([12, 12, 4, 4], MARGIN_DB, matrix.shape)(matrix)
    step_hz = rate_hz / (2 * len(reference))
    rows, columns = np.nonzero(hits)
    found = [
        ((row - len(matrix) // 2) * step_hz, column / rate_hz, 10 * np.log10(over_noise[row, column]))
        for row, column in zip(rows, columns, strict=True)
    ]
    return sorted((one for one in found if abs(one[0]) > RESTS_HZ), key=lambda one: -one[2])


def main(path):
    with h5py.File(path) as file:
        iq, rate_hz = file["iq"][:], file.attrs["sample_rate_hz"]
        delay_s, doppler_hz = (file[f"truth/{name}"][:, 1].mean(axis=0) for name in ("delay_s", "doppler_hz"))
        names = [name.decode() if isinstance(name, bytes) else str(name) for name in file["truth/targets"][:]]
        tower, station = (file[f"nav/{name}/phase_centre_m"][0] for name in ("tv", "reference"))
    direct_s = np.linalg.norm(tower - station) / C_MPS
    cell_hz, cell_s = rate_hz / (iq.shape[0] * iq.shape[2]), 1.0 / rate_hz
    found = detections(iq[:, 0].reshape(-1).astype(complex), iq[:, 1].reshape(-1).astype(complex), rate_hz)
    missing = []
    for name, tau_s, f_hz in zip(names, delay_s, doppler_hz, strict=True):
        near = [
            one for one in found
            if abs(one[0] - f_hz) <= cell_hz and abs(one[1] + direct_s - tau_s) <= cell_s
        ]
        if not near:
            missing.append(name)
            continue
        hz, s, level_db = near[0]
        print(f"{name}: detected at {hz:.1f} Hz and {1e6 * (s + direct_s):.3f} us, {level_db:.1f} dB over its surroundings; "
              f"truth {f_hz:.2f} Hz and {1e6 * tau_s:.4f} us")
    if missing:
        sys.exit(f"{path}: not detected: {', '.join(missing)}")


if __name__ == "__main__":
    main(sys.argv[1])
