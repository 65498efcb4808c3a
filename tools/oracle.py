#!/usr/bin/env python3
"""Recomputes pulses of a noiseless recording from first principles and compares them with /iq.

    oracle.py RECORDING.h5 [--rows 0,7,19 | --count 4] [--limit-db -100] [--json]

Needs numpy and h5py, and nothing of nereus: what is computed here (package `oracle` beside this file) follows
the printed equations, by other means wherever there are any. The scenario comes from the attribute `config`; from
the columns come the true (and reported) states of the platforms and the start of each window. Nothing of /truth
is used.

For every emission whose echo meets the window, transmitter, receiver and target:

    light time    tau1 = |x_s(t+tau1) - x_T(t)|/c,  tau2 = |x_R(t+tau1+tau2) - x_s(t+tau1)|/c
    amplitude     a = sqrt(P lambda^2/((4 pi)^3 L)) g_t g_r/(R_t R_r) (e_r . S e_t),  bases (v, h)
    direct path   a = sqrt(P lambda^2/((4 pi)^2 L)) g_t g_r/R (e_r . e_t)
    samples       s(t) = a exp(-j 2 pi f0 tau) q(t - t_m - tau)
                  q(t) = int_0^Tc p(u) exp(-j 2 pi f0 r u) h(t - x) dx,  x = (1 + r) u,  r = d tau/dt

h is the impulse response of the receive filter in closed form (1 up to 0.4 fs, raised cosine to 0 at
0.5 fs), so q is made in the time domain by Gauss-Legendre quadrature: no spectrum, no FFT, no period.

A sea is recomputed too: its spectrum, its waves from their random numbers, every facet of the patch with its
scattering matrix, at every emission (module `oracle.sea`). A facet is a scatterer as above, on a straight course
during the echo.

The transmit antenna is that of the instant of emission, the receive antenna that of the instant of
reception. Between pulses, positions are cubic Hermite on position and velocity, attitudes slerp.

Printed is 20 log10(||recorded - computed|| / ||computed||) by pulse and channel. Single precision of the
samples allows -150 dB; f64 phases of X band at 6 ms of delay allow -135 dB. Exit 0: all below the limit;
1: not; 2: the recording cannot be judged: noise, converter, file patterns or waveforms; slicks, swell, ships;
spectra other than Elfouhaily's and Fung and Lee's; averages over cells of the spectrum; shadows that may fall; what
lies beyond the horizon of a curved earth.
"""

import argparse
import json
import math
import sys
import tomllib

import numpy as np

from oracle.echo import pulse
from oracle.frames import Unfit
from oracle.scene import Scene, Track
from oracle.sea import Sea


def decibels(x):
    return 20 * math.log10(x) if x > 0 else -math.inf


def judge(path, rows=None, count=4):
    """Relative errors in dB by row and channel, and what else was noticed."""
    import h5py

    with h5py.File(path, "r") as file:
        config = tomllib.loads(file.attrs["config"])
        text = lambda x: x.decode() if isinstance(x, bytes) else x
        channels = [
            (text(c["transmitter"]), text(c["receiver"]), text(c["polarisations"]))
            for c in file["channel"][:]
        ]
        index = file["pulse/index"][:]
        start = int(file.attrs["start_time_ns"]), float(file.attrs["start_time_frac_ns"])
        times = (file["pulse/time_ns"][:] - start[0]) * 1e-9
        times = times + (file["pulse/time_frac_ns"][:] - start[1]) * 1e-9
        track = lambda group: Track(
            times, *(group[c][:] for c in ("position_m", "velocity_mps", "attitude_quat"))
        )
        tracks = {
            p["name"]: {k: track(file[f"nav/{p['name']}/{k}"]) for k in ("true", "reported")}
            for p in config["platform"]
        }
        scene = Scene(config, tracks, channels)
        sea = Sea(config, scene, int(file.attrs["seed"])) if "sea" in config else None
        n = len(index)
        if n == 0:
            raise Unfit("the recording holds no pulse")
        if rows is None:
            rows = sorted({round(k * (n - 1) / max(count - 1, 1)) for k in range(count)})
        # What the recording has about itself: emission times and phase centres.
        clock = max(abs(times[k] - scene.emission(int(index[k]))) for k in range(n))
        arms = max(
            float(np.linalg.norm(a.centre(times[k : k + 1])[0] - file[f"nav/{name}/phase_centre_m"][k]))
            for name, a in scene.antennas.items()
            for k in rows
        )
        samples = file["iq"].shape[2]
        result = []
        for k in rows:
            start_s = float(file["pulse/window_start_s"][k])
            want, met = pulse(scene, sea, channels, int(index[k]), start_s, samples)
            got = file["iq"][k].astype(complex)
            error, level = np.linalg.norm(got - want, axis=-1), np.linalg.norm(want, axis=-1)
            db = [
                decibels(e / s) if s > 0 else (-math.inf if e == 0 else math.inf)
                for e, s in zip(error, level)
            ]
            result.append({"pulse": int(index[k]), "echoes": met, "error_db": db, "rms": list(level)})
        names = [text(c) for c in file["channel"]["name"]]
    return {
        "path": str(path),
        "channels": names,
        "worst_db": max(d for r in result for d in r["error_db"]),
        "clock_s": float(clock),
        "phase_centre_m": float(arms),
        "pulses": result,
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("recording")
    parser.add_argument("--rows", type=lambda s: [int(k) for k in s.split(",")], help="rows, e.g. 0,7,19")
    parser.add_argument("--count", type=int, default=4, help="otherwise so many, evenly spread")
    parser.add_argument("--limit-db", type=float, default=-100.0)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    try:
        found = judge(args.recording, args.rows, args.count)
    except (Unfit, OSError) as error:
        print(f"oracle.py: {args.recording}: {error}", file=sys.stderr)
        return 2
    # Emission times may be rounded to a femtosecond or so; phase centres to f64 of their coordinates.
    sound = found["worst_db"] <= args.limit_db and found["clock_s"] < 1e-12 and found["phase_centre_m"] < 1e-8
    if args.json:
        print(json.dumps(found | {"limit_db": args.limit_db, "sound": sound}))
        return 0 if sound else 1
    print(f"{args.recording}: relative rms, dB")
    print("  pulse  echoes  " + "  ".join(f"{c:>8}" for c in found["channels"]))
    for r in found["pulses"]:
        print(f"{r['pulse']:7}  {r['echoes']:6}  " + "  ".join(f"{d:8.1f}" for d in r["error_db"]))
    print(f"  emission times {found['clock_s']:.1e} s, phase centres {found['phase_centre_m']:.1e} m apart")
    print(
        f"  worst {found['worst_db']:.1f} dB, limit {args.limit_db:g} dB: {'sound' if sound else 'NOT SOUND'}"
    )
    return 0 if sound else 1


if __name__ == "__main__":
    sys.exit(main())
