#!/usr/bin/env python3
"""Is a long recording at its end what it was at its beginning?

    tools/steady.py RECORDING.h5 [--pulses 2000] [--limit-db DB] [--json]
    tools/steady.py --run configs/mars-live.toml [--duration-s 3600] [--pace fast] [--set KEY=VALUE] --out live.h5

The first and the last pulses of a recording (HDF5, or a plain folder) are set side by side, channel by channel:

    power       mean of |s|^2, dBW, and the standard error of the difference, from groups of 50 pulses
    kurtosis    <|s|^4>/<|s|^2>^2: 2 for Gaussian noise, more for a spiky sea
    Doppler     PRF/(2 pi) arg sum conj(s_k) s_(k+1): the centroid, within half the PRF

Samples that are not finite, pulses that are missing and flags are counted over the whole recording. With --run, nereus makes the recording
and its resident memory is read every second: that after the first tenth of the run, or its first 20 s, is compared with that at the end.

A flight that turns or climbs changes power and Doppler by itself, so these are shown and not judged; --limit-db judges the power.
Judged are: samples not finite, pulses missing, and, of runs of a minute and more, memory that has grown by more than a tenth and 16 MiB.
Exit 0: steady; 1: not; 2: cannot be read or made. Needs numpy and h5py; memory needs Linux.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import time

PACKAGE = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(PACKAGE / "python/nereus"))

try:
    import numpy as np

    from reader import open_recording
except ImportError as missing:
    print(f"steady.py: {missing}; install with: pip install numpy h5py", file=sys.stderr)
    sys.exit(2)

GROUP = 50  # pulses whose mean is one value for the standard error
STRIDE = 5000  # pulses that are read at once


def decibels(x):
    return 10 * math.log10(x) if x > 0 else -math.inf


def figures(samples, prf_hz):
    """Statistics of [pulse, channel, sample], per channel."""
    power = np.abs(samples.astype(complex)) ** 2
    mean, fourth = power.mean(axis=(0, 2)), (power**2).mean(axis=(0, 2))
    count = max(1, len(power) // GROUP)
    groups = np.array([group.mean(axis=(0, 2)) for group in np.array_split(power, count)])
    error = groups.std(axis=0, ddof=1) / math.sqrt(count) if count > 1 else np.full(len(mean), np.nan)
    turn = np.sum(np.conj(samples[:-1]).astype(complex) * samples[1:], axis=(0, 2))
    with np.errstate(divide="ignore", invalid="ignore"):
        return {
            "power_w": mean,
            "error_w": error,
            "kurtosis": fourth / mean**2,
            "doppler_hz": np.angle(turn) * prf_hz / (2 * math.pi),
        }


def compare(path, pulses):
    """The description of a recording, as a dictionary."""
    with open_recording(path) as rec:
        n = rec.pulses
        if n < 2:
            raise ValueError(f"{path}: {n} pulses are too few")
        pulses = max(2, min(pulses, n // 2))
        prf_hz = float(rec.meta["prf_hz"])
        names = list(rec.meta["channels"])
        bad = 0
        for begin in range(0, n, STRIDE):
            bad += int(np.count_nonzero(~np.isfinite(rec.samples(begin, begin + STRIDE))))
        index = np.asarray(rec["pulse/index"][:n])
        flags = np.asarray(rec["pulse/flags"][:n])
        first = figures(rec.samples(0, pulses), prf_hz)
        last = figures(rec.samples(n - pulses, n), prf_hz)
    channels = []
    for c, name in enumerate(names):
        a, b = (float(part["power_w"][c]) for part in (first, last))
        # Of a ratio near 1: relative errors add up in squares; a relative error e is 10/ln(10) e dB.
        relative = [float(part["error_w"][c]) / p if p > 0 else math.nan for part, p in ((first, a), (last, b))]
        channels.append(
            {
                "channel": name,
                "first_dbw": decibels(a),
                "last_dbw": decibels(b),
                "change_db": decibels(b) - decibels(a) if a > 0 and b > 0 else 0.0 if a == b else math.inf,
                "error_db": 10 / math.log(10) * math.hypot(*relative),
                "kurtosis": [float(part["kurtosis"][c]) for part in (first, last)],
                "doppler_hz": [float(part["doppler_hz"][c]) for part in (first, last)],
            }
        )
    return {
        "path": str(path),
        "pulses": int(n),
        "compared": int(pulses),
        "span_s": float(index[-1] - index[0] + 1) / prf_hz,
        "not_finite": bad,
        "missing": int(index[-1] - index[0] + 1 - n),
        "flagged": int(np.count_nonzero(flags)),
        "channels": channels,
    }


def resident_mib(pid):
    """Resident memory of a process, or None."""
    try:
        with open(f"/proc/{pid}/status", encoding="ascii") as file:
            for line in file:
                if line.startswith("VmRSS"):
                    return int(line.split()[1]) / 1024
    except OSError:
        pass
    return None


def make(args):
    """Runs nereus and returns its memory as (s, MiB), and its summary."""
    command = [args.nereus, "run", args.run, "--pace", args.pace, "--out", args.out, "--json"]
    command += ["--force"] if args.force else []
    command += ["--duration-s", str(args.duration_s)] if args.duration_s else []
    command += [word for setting in args.set for word in ("--set", setting)]
    memory, begun = [], time.monotonic()
    shown = begun
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        while True:
            now = resident_mib(child.pid)
            if now is not None:
                memory.append((time.monotonic() - begun, now))
            try:
                child.wait(min(1.0, 0.1 * max(1, len(memory))))
                break
            except subprocess.TimeoutExpired:
                pass
            if time.monotonic() - shown > 60:
                shown = time.monotonic()
                print(f"steady.py: {memory[-1][1]:.0f} MiB resident" if memory else "", file=sys.stderr)
        summary = child.stdout.read()
        if child.returncode != 0:
            raise ValueError(f"nereus ended with {child.returncode}")
    return memory, json.loads(summary.splitlines()[-1])


def finite(value):
    """The same with null for what is no number: JSON knows none of these."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def show(result):
    print(f"{result['path']}: {result['pulses']} pulses over {result['span_s']:.1f} s", end="; ")
    print(f"{result['missing']} missing, {result['flagged']} flagged, {result['not_finite']} samples not finite")
    print(f"first and last {result['compared']} pulses")
    print("  channel      dBW      dBW   change, dB          kurtosis       Doppler, Hz")
    for c in result["channels"]:
        print(
            f"  {c['channel']:7} {c['first_dbw']:8.2f} {c['last_dbw']:8.2f} {c['change_db']:6.2f} +- {c['error_db']:4.2f}"
            f" {c['kurtosis'][0]:8.2f} {c['kurtosis'][1]:8.2f} {c['doppler_hz'][0]:8.2f} {c['doppler_hz'][1]:8.2f}"
        )
    if "memory_mib" in result:
        early, late = result["memory_mib"]
        print(f"resident memory {early:.1f} MiB early in the run, {late:.1f} MiB at its end")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", nargs="?")
    parser.add_argument("--pulses", type=int, default=2000, help="so many at either end")
    parser.add_argument("--limit-db", type=float, help="most that a power may change beside 4 standard errors")
    parser.add_argument("--run", metavar="CONFIG", help="make the recording first")
    parser.add_argument("--out", help="--run: the recording")
    parser.add_argument("--duration-s", type=float)
    parser.add_argument("--pace", choices=("fast", "realtime"), default="fast")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--force", action="store_true", help="--run: overwrite")
    parser.add_argument("--nereus", default=str(PACKAGE / "target/release/nereus"))
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    if bool(args.run) == bool(args.recording) or bool(args.run) != bool(args.out):
        parser.error("either RECORDING, or --run CONFIG --out RECORDING")
    try:
        memory, run = make(args) if args.run else ([], None)
        result = compare(args.out or args.recording, args.pulses)
    except (OSError, ValueError) as error:
        print(f"steady.py: {error}", file=sys.stderr)
        return 2
    steady = result["not_finite"] == 0 and result["missing"] == 0
    if memory and memory[-1][0] >= 60.0:
        since_s = max(0.1 * memory[-1][0], 20.0)
        early = next(mib for t, mib in memory if t >= since_s)
        # The last reading may find a process that is already going.
        late = max(mib for _, mib in memory[-4:])
        result["memory_mib"] = [early, late]
        steady &= late - early <= max(0.1 * early, 16.0)
    if run is not None:
        result["run"] = run
    if args.limit_db is not None:
        steady &= all(abs(c["change_db"]) <= args.limit_db + 4 * c["error_db"] for c in result["channels"])
    result["steady"] = bool(steady)
    print(json.dumps(finite(result), allow_nan=False)) if args.json else show(result)
    if not args.json:
        print("steady" if steady else "NOT steady")
    return 0 if steady else 1


if __name__ == "__main__":
    sys.exit(main())
