#!/usr/bin/env python3
"""Reads a recording of nereus: finished, growing, or left by a killed run.

As a program:   reader.py RECORDING [--follow] [--json]
As a module:    with reader.open_recording(path) as rec: rec.pulses, rec["iq"][a:b], rec.nav("rx", "true")

A recording is an HDF5 file (needs h5py) or a folder made by the plain sink (needs numpy alone).
Both hold the same columns under the same paths. The first `rec.pulses` rows of every column are
complete; `rec.refresh()` looks again. A killed HDF5 file has the open-for-write flag, so it is
opened with swmr=True where a plain open is refused.
"""
import argparse
import json
import os
import signal
import sys
import time

import numpy as np

FLAGS = {
    1: "late",
    2: "after a gap",
    4: "ADC saturated",
    8: "outside the window",
    16: "motion extrapolated",
    32: "navigation stale",
    64: "report dropped out",
}
WORDS = ("description", "unit", "axes", "frame")
CHANGE_KEYS = ("pulse", "time_ns", "platform", "text", "source")


class Recording:
    """What both kinds have in common. `meta` holds the attributes by name."""

    def refresh(self):
        """Looks for new pulses; returns how many are complete."""
        raise NotImplementedError

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def samples(self, a=0, b=None):
        """Samples of rows a..b as complex64 [pulse, channel, sample], in sqrt(W)."""
        iq = self._rows("iq", a, self.pulses if b is None else min(b, self.pulses))
        step = self.meta.get("adc_step")
        if iq.dtype.names:  # codes of a mid-rise converter in HDF5
            iq = np.stack([iq["r"], iq["i"]], axis=-1)
        if iq.dtype.kind == "i":
            iq = (iq.astype(np.float32) + np.float32(0.5)) * np.float32(step)
            iq = iq[..., 0] + 1j * iq[..., 1]
        return iq.astype(np.complex64)

    def _rows(self, column, a, b):
        """Rows of a column. A chunk read in the moment in which it is written again fails its checksum: once more then."""
        for wait_s in (0.05, 0.2, 1.0):
            try:
                return self[column][a:b]
            except OSError:
                time.sleep(wait_s)
        return self[column][a:b]

    def nav(self, platform, which="reported"):
        """Position, velocity, attitude quaternion of a platform, per pulse."""
        base = f"nav/{platform}/{which}/"
        names = ("position_m", "velocity_mps", "attitude_quat")
        return tuple(self[base + name][: self.pulses] for name in names)

    def words(self, column):
        """What a dataset is: description, unit, axes, frame. Empty in recordings of earlier versions."""
        raise NotImplementedError

    def ships(self):
        """Names of the ships whose tracks are in the truth record."""
        raise NotImplementedError

    def changes(self):
        """What was changed of reports up to the last pulse: dictionaries with pulse, time_ns, platform, text, source."""
        raise NotImplementedError

    def ship(self, name):
        """True position, velocity, and heading (degrees clockwise from North) of a ship, per pulse."""
        place = self.ships().index(name)
        names = ("ship_position_m", "ship_velocity_mps", "ship_heading_deg")
        return tuple(self["truth/" + column][: self.pulses, place] for column in names)

    def emission(self):
        """Emission times as (integer ns UTC, fraction of a ns)."""
        n = self.pulses
        return self["pulse/time_ns"][:n], self["pulse/time_frac_ns"][:n]


class Hdf5Recording(Recording):
    def __init__(self, path):
        import h5py

        self.path = path
        try:
            self.file = h5py.File(path, "r")
            self.state = "closed"
        except OSError:
            self.file = h5py.File(path, "r", swmr=True)
            self.state = "open: growing, or left by a killed run"
        self.meta = {k: _plain(v) for k, v in self.file.attrs.items()}
        if self.meta.get("format") != "nereus":
            raise ValueError(f"{path}: not a recording of nereus")
        self.meta.update({k: _plain(v) for k, v in self.file["iq"].attrs.items() if k not in WORDS})
        self.columns = []
        self.file.visititems(self._note)
        self.refresh()

    def _note(self, name, item):
        per_pulse = name != "truth/changes"
        if per_pulse and hasattr(item, "shape") and item.maxshape and item.maxshape[0] is None:
            self.columns.append(name)

    def refresh(self):
        # The index first: whatever the writer does meanwhile, the others are at least as long.
        self.file["pulse/index"].refresh()
        self.pulses = len(self.file["pulse/index"])
        for name in self.columns:
            if name != "pulse/index":
                self.file[name].refresh()
        return self.pulses

    def __getitem__(self, column):
        return self.file[column]

    def words(self, column):
        return {k: _plain(v) for k, v in self.file[column].attrs.items() if k in WORDS}

    def ships(self):
        return [name.decode() for name in self.file["truth/ships"][:]] if "truth/ships" in self.file else []

    def changes(self):
        if "truth/changes" not in self.file:
            return []
        table = self.file["truth/changes"]
        table.refresh()
        return [{k: _plain(row[k]) for k in CHANGE_KEYS} for row in table[:]]

    def close(self):
        self.file.close()


class PlainRecording(Recording):
    def __init__(self, path):
        self.path = path
        with open(os.path.join(path, "meta.json"), encoding="utf-8") as f:
            self.meta = json.load(f)
        if self.meta.get("format") != "nereus":
            raise ValueError(f"{path}: not a recording of nereus")
        self.columns = list(self.meta["columns"])
        self.state = "closed, growing, or left by a killed run"
        self.refresh()

    def refresh(self):
        self.pulses = os.path.getsize(os.path.join(self.path, "pulse/index.bin")) // 8
        return self.pulses

    def __getitem__(self, column):
        if column == "replica":
            return np.fromfile(os.path.join(self.path, "replica.bin"), self.meta["replica_dtype"])
        what = self.meta["columns"][column]
        dtype, shape = np.dtype(what["dtype"]), tuple(what["shape"])
        if self.pulses == 0:
            return np.zeros((0, *shape), dtype)
        file = os.path.join(self.path, column + ".bin")
        return np.memmap(file, dtype, "r", shape=(self.pulses, *shape))

    def words(self, column):
        entry = self.meta["columns"].get(column) or self.meta.get("descriptions", {}).get(column, {})
        return {k: v for k, v in entry.items() if k in WORDS}

    def ships(self):
        return self.meta.get("ships", [])

    def changes(self):
        try:
            with open(os.path.join(self.path, "truth/changes.jsonl"), encoding="utf-8") as f:
                return [json.loads(line) for line in f if line.endswith("\n")]
        except FileNotFoundError:
            return []

    def close(self):
        pass


def _plain(value):
    """An attribute as a Python value."""
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, np.ndarray):
        return [_plain(v) for v in value.tolist()]
    return value.item() if isinstance(value, np.generic) else value


def open_recording(path):
    """Opens a recording of either kind."""
    if os.path.exists(path) and not (os.path.isfile(path) or os.path.isdir(path)):
        raise ValueError(f"{path}: is a pipe or a device; allowed: a recording")
    return PlainRecording(path) if os.path.isdir(path) else Hdf5Recording(path)


def summary(rec):
    """What a recording holds, as a dictionary."""
    n = rec.pulses
    index = np.asarray(rec["pulse/index"][:n])
    flags = np.asarray(rec["pulse/flags"][:n])
    out = {
        "path": rec.path,
        "state": rec.state,
        "pulses": int(n),
        "first": int(index[0]) if n else None,
        "last": int(index[-1]) if n else None,
        "missing": int(index[-1] - index[0] + 1 - n) if n else 0,
        "flags": {name: int(np.count_nonzero(flags & bit)) for bit, name in FLAGS.items()},
        "changes": rec.changes(),
        "channels": rec.meta["channels"],
        "iq_shape": [int(n), *(int(k) for k in rec["iq"].shape[1:])],
        "columns": {c: list(map(int, rec[c].shape)) for c in sorted(rec.columns)},
        "words": {c: rec.words(c) for c in sorted(rec.columns)},
    }
    keys = ("carrier_hz", "sample_rate_hz", "bandwidth_hz", "pulse_s", "prf_hz", "seed", "software")
    out.update({k: rec.meta[k] for k in keys})
    out["emitters"] = json.loads(rec.meta.get("instrument") or "{}").get("emitters", [])
    if n:
        last = rec.samples(n - 1, n)[0]
        out["last_rms"] = [float(np.sqrt(np.mean(np.abs(channel) ** 2))) for channel in last]
    return out


def show(s):
    """A summary as text."""
    print(f"{s['path']}: {s['state']}; {s['software']}, seed {s['seed']}")
    print(f"  {s['pulses']} pulses ({s['first']} to {s['last']}, {s['missing']} missing) at {s['prf_hz']:g} Hz")
    print(f"  channels {' '.join(s['channels'])}; iq {s['iq_shape']} at {s['sample_rate_hz']:g} Hz")
    print(f"  carrier {s['carrier_hz']:g} Hz, bandwidth {s['bandwidth_hz']:g} Hz, pulse {s['pulse_s']:g} s")
    for e in s["emitters"]:
        taken = " and ".join(w for w, k in (("direct path", "direct_path"), ("echo", "echo")) if e[k]) or "nothing"
        print(
            f"  emitter {e['antenna']['name']} on {e['antenna']['platform']}: {e['carrier_hz']:g} Hz, bandwidth {e['bandwidth_hz']:g} Hz, "
            f"pulse {e['pulse_s']:g} s, {e['prf_hz']:g} Hz from {e['start_s']:g} s, {e['power_w']:g} W {e['polarisation']}; "
            f"{taken} at {', '.join(e['receivers'])}"
        )
    print("  flagged: " + ", ".join(f"{v} {k}" for k, v in s["flags"].items()))
    for change in s["changes"]:
        print(f"  from pulse {change['pulse']}: {change['text']} on {change['platform']} ({change['source']})")
    if "last_rms" in s:
        rms = ", ".join(f"{c} {v:.3e}" for c, v in zip(s["channels"], s["last_rms"]))
        print(f"  rms of the last pulse, sqrt(W): {rms}")
    for name, shape in s["columns"].items():
        words = s["words"][name]
        print(f"  /{name} {shape}" + (f": {words['unit']}, {words['axes']}" if words else ""))


def follow(rec, timeout_s):
    """Prints a line when pulses have come; ends when none came for `timeout_s`."""
    seen, last = 0, time.monotonic()
    while True:
        n = rec.refresh()
        if n > seen:
            index = np.asarray(rec["pulse/index"][seen:n])
            print(f"{n} pulses, up to {int(index[-1])}", flush=True)
            seen, last = n, time.monotonic()
        elif time.monotonic() - last > timeout_s:
            return
        time.sleep(0.1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("recording")
    parser.add_argument("--follow", action="store_true", help="report pulses while the recording grows")
    parser.add_argument("--timeout-s", "--patience-s", type=float, default=5.0, help="--follow ends when no pulse came for so long")
    parser.add_argument("--json", action="store_true", help="print the summary as one JSON object")
    args = parser.parse_args()
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `reader.py ... | head` ends quietly
    try:
        with open_recording(args.recording) as rec:
            if args.follow:
                follow(rec, args.timeout_s)
            s = summary(rec)
    except (OSError, ValueError) as error:
        print(f"reader.py: {args.recording}: {error}", file=sys.stderr)
        return 2
    print(json.dumps(s)) if args.json else show(s)
    return 0


if __name__ == "__main__":
    sys.exit(main())
