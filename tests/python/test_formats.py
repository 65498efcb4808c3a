#!/usr/bin/env python3
"""CRSD, SigMF and DIFI of random scenes, each judged by what shares no code with nereus.

    tests/python/test_formats.py [--nereus target/debug/nereus] [--seed N]

A run of every scene of random_scenes.py writes a recording and a CRSD file and sends DIFI packets to a socket of this test; the
recording becomes CRSD and SigMF. Of each scene

* `crsdcheck --thorough` passes, the export equals the run's own file, and samples, times, positions and axes are the recording's;
* the reference geometry is the standard's to 1e-6 m and degrees with products that are rounded and with fused ones, as processors
  differ in these, and its ground ranges are those of well-conditioned equations as far as a cosine in doubles can tell;
* the reader of sigmf takes schema, hashes and lengths; samples, instants, places and annotations are the recording's;
* a parser of the standard (difi.py) takes every packet; samples, time stamps, rates and levels are the recording's.

100 scenes, times NEREUS_CASES; below 1 one of each family. Without tests/python/requirements.txt it is skipped.
"""
import argparse
import contextlib
import fractions
import json
import os
import shutil
import socket
import sys
import tempfile
import threading
import types

import random_scenes
import test_crsd

#: Packets that wait in a socket's buffer if this process gets no processor meanwhile.
WAITING = 100
HALF_ULP = 2.0**-53


class Received(threading.Thread):
    """Datagrams of a socket on loopback until it is closed."""

    def __init__(self):
        super().__init__(daemon=True)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.2)
        self.address = "127.0.0.1:{}".format(self.socket.getsockname()[1])
        self.datagrams, self.is_over = [], False
        self.start()

    def run(self):
        while True:
            try:
                self.datagrams.append(self.socket.recv(1 << 16))
            except TimeoutError:
                if self.is_over:
                    return

    def end(self):
        self.is_over = True
        self.join()
        self.socket.close()
        return self.datagrams


def rounded(a, b):
    """A scalar product of which every product and sum is rounded."""
    import numpy as np

    return np.add.reduce(np.asarray(a) * np.asarray(b), axis=-1)


def fused(a, b):
    """A scalar product by fused multiply-adds."""
    import numpy as np

    a, b = ([fractions.Fraction(float(x)) for x in v] for v in (a, b))
    total = float(a[0] * b[0])
    for x, y in zip(a[1:], b[1:]):
        total = float(fractions.Fraction(total) + x * y)
    return np.float64(total)


@contextlib.contextmanager
def products(inner):
    """sarkit's computations with another scalar product."""
    import numpy as np
    import sarkit.crsd._computations as computations

    computations.np = types.SimpleNamespace(**{**vars(np), "inner": inner})
    try:
        yield
    finally:
        computations.np = np


def ground_range(position, point):
    """Along the sphere of the standard, by an arc tangent."""
    import numpy as np

    angle = np.arctan2(np.linalg.norm(np.cross(position, point)), np.dot(position, point))
    return np.linalg.norm(point) * angle, angle


def check_geometry(crsd):
    import numpy as np
    import sarkit.crsd

    with open(crsd, "rb") as file:
        reader = sarkit.crsd.Reader(file)
        xml = reader.metadata.xmltree
        vectors = reader.read_pvps(xml.findtext("{*}Channel/{*}RefChId"))
        pulses = reader.read_ppps(xml.findtext("{*}TxSequence/{*}RefTxId"))
    own = sarkit.crsd.ElementWrapper(xml.getroot())["ReferenceGeometry"]
    for inner in (rounded, fused):
        with products(inner), np.errstate(all="ignore"):
            wanted = sarkit.crsd.compute_reference_geometry(xml, pvps=vectors, ppps=pulses)
        for part, values in sarkit.crsd.ElementWrapper(wanted).to_dict().items():
            for key, value in values.items():
                found = own[part][key]
                same = found == value if isinstance(value, str) else np.allclose(found, value, rtol=0, atol=1e-6)
                assert same, f"{part}/{key}: {found}; {value} with products that are {inner.__name__}"
    point = np.array(own["RefPoint"]["ECF"])
    for part, position in (("TxParameters", "APCPos"), ("RcvParameters", "APCPos"), ("SARImage", "ARPPos")):
        true, angle = ground_range(np.array(own[part][position]), point)
        # 1 - cos, off by what roundings of two unit vectors and of their product make of it: 3 units each of half an ulp, and one.
        less = 2 * np.sin(angle / 2) ** 2
        ends = [2 * np.arcsin(np.sqrt(max(less + k * HALF_ULP, 0.0) / 2)) for k in (-7, 7)]
        low, high = (np.linalg.norm(point) * end for end in ends)
        assert low - 1e-8 <= own[part]["GroundRange"] <= high + 1e-8, (part, own[part]["GroundRange"], true, low, high)


def instants(h5):
    """Emissions of pulses, exact, ns."""
    return [int(ns) + fractions.Fraction(float(part)) for ns, part in zip(h5["pulse/time_ns"][:], h5["pulse/time_frac_ns"][:])]


def ns_of(text):
    """A UTC time of a SigMF file as nanoseconds since 1970."""
    import datetime

    whole, _, part = text.removesuffix("Z").partition(".")
    seconds = datetime.datetime.fromisoformat(whole).replace(tzinfo=datetime.timezone.utc).timestamp()
    return int(seconds) * 10**9 + int(part.ljust(9, "0"))


def raw(h5, channel):
    import numpy as np

    iq = h5["iq"][:, channel]
    return np.stack([iq["r"], iq["i"]], -1) if iq.dtype.names else np.stack([iq.real, iq.imag], -1)


def check_sigmf(nereus, recording, h5, base):
    import numpy as np
    import sarkit.wgs84
    import sigmf

    test_crsd.run(nereus, "export", "sigmf", recording, "--out", base)
    rows = [[field.decode() for field in row] for row in h5["channel"][:]]
    names = [os.path.basename(base) + (f"-{row[0]}" if len(rows) > 1 else "") for row in rows]
    if len(rows) > 1:
        collection = sigmf.fromfile(base + ".sigmf-collection")
        collection.verify_stream_hashes()
        assert collection.get_stream_names() == names
    emitted, scene = instants(h5), test_crsd.Scene(h5)
    pulse = {key: h5["pulse/" + key][:] for key in ("index", "time_ns", "time_frac_ns", "window_start_s", "flags", "tx_pol")}
    carrier, band, length = (float(h5.attrs[key]) for key in ("carrier_hz", "bandwidth_hz", "sample_rate_hz"))
    for place, (name, row) in enumerate(zip(names, rows)):
        path = os.path.join(os.path.dirname(base), name + ".sigmf-meta")
        file = sigmf.fromfile(path, autoscale=False)
        file.validate()
        with open(path, encoding="utf-8") as text:
            meta = json.load(text)
        assert meta["global"]["core:sample_rate"] == length and meta["global"]["nereus:bandwidth_hz"] == band
        assert meta["global"]["nereus:channel"]["name"] == row[0]
        samples = file.read_samples()
        samples = np.stack([samples.real, samples.imag], -1) if samples.dtype.kind == "c" else samples
        wanted = raw(h5, place)
        assert np.array_equal(samples.reshape(wanted.shape), wanted), name
        (capture,) = meta["captures"]
        assert capture["core:frequency"] == carrier
        window = [fractions.Fraction(float(s)) * 10**9 for s in pulse["window_start_s"]]
        assert abs(ns_of(capture["core:datetime"]) - (emitted[0] + window[0])) <= 1, capture
        assert len(meta["annotations"]) == len(emitted)
        for i, of in enumerate(meta["annotations"]):
            assert (of["core:sample_start"], of["core:sample_count"]) == (i * wanted.shape[1], wanted.shape[1])
            assert (of["core:freq_lower_edge"], of["core:freq_upper_edge"]) == (carrier - band / 2, carrier + band / 2)
            assert abs(ns_of(of["nereus:emission"]) - emitted[i]) <= 1
            for key, column in (("pulse", "index"), ("emission_ns", "time_ns"), ("emission_frac_ns", "time_frac_ns"),
                                ("window_start_s", "window_start_s"), ("flags", "flags"), ("tx_pol", "tx_pol")):
                assert of["nereus:" + key] == pulse[column][i], (key, i)
            for end, antenna in (("transmitter", row[1]), ("receiver", row[2])):
                centre = h5[f"nav/{antenna}/reported_phase_centre_m"][i]
                assert of[f"nereus:{end}_enu_m"] == centre.tolist()
                lat, lon, high = sarkit.wgs84.cartesian_to_geodetic(scene.ecef(centre))
                found = of[f"nereus:{end}_geolocation"]["coordinates"]
                turn = (found[0] - lon + 180) % 360 - 180
                off_m = [turn * 111e3 * np.cos(np.radians(lat)), (found[1] - lat) * 111e3, found[2] - high]
                assert np.linalg.norm(off_m) < 1e-5, (end, found, lat, lon, high)


def check_difi(datagrams, h5):
    import difi
    import numpy as np

    packets = [difi.parse(datagram) for datagram in datagrams]
    emitted, step = instants(h5), float(h5["iq"].attrs["adc_step"])
    opened = [fractions.Fraction(float(s)) * 10**9 for s in h5["pulse/window_start_s"][:]]
    rate = float(h5.attrs["sample_rate_hz"])
    assert {p["stream"] for p in packets} == {0x10000000 + c for c in range(h5["iq"].shape[1])}
    for channel in range(h5["iq"].shape[1]):
        signal, context, version = ([p for p in packets if p["stream"] == 0x10000000 + channel and p["type"] == t] for t in (1, 4, 5))
        for of in (signal, context, version):
            assert [p["count"] for p in of] == [n % 16 for n in range(len(of))], channel
        assert [p["changed"] for p in context] == [p["changed"] for p in version] == [1] + [0] * (len(context) - 1)
        assert abs(context[0]["time"] - emitted[0] * 1000) <= 1
        for p in context:
            for found, key in ((p["bandwidth"], "bandwidth_hz"), (p["rf"], "carrier_hz"), (p["rate"], "sample_rate_hz")):
                assert abs(found - float(h5.attrs[key])) <= 2.0**-20, (key, found)
            assert abs(p["level"] - (20 * np.log10(2**15 * step) + 30)) <= 1 / 256, p
        wanted = raw(h5, channel)
        (shape,) = {p["samples"].shape for p in signal}
        assert np.array_equal(np.concatenate([p["samples"] for p in signal]).reshape(wanted.shape), wanted), channel
        each = wanted.shape[1] // shape[0]
        for n, p in enumerate(signal):
            first = (emitted[n // each] + opened[n // each]) * 1000 + fractions.Fraction(n % each * shape[0]) / fractions.Fraction(rate) * 10**12
            assert abs(p["time"] - first) <= 1, (channel, n, float(p["time"] - first))


def judge(nereus, folder, seed):
    import h5py
    import numpy as np

    # Every other scene has an ADC: DIFI sends nothing else.
    has_adc = seed // len(random_scenes.FAMILIES) % 2 == 0
    text, family = random_scenes.scene(seed, has_adc)
    scenario, recording, crsd, direct, base = (os.path.join(folder, name) for name in ("a.toml", "a.h5", "a.crsd", "b.crsd", "a"))
    received = Received() if has_adc else None
    with open(scenario, "w", encoding="utf-8") as file:
        file.write(text)
        file.write(f'[[sink]]\nkind = "hdf5"\npath = "{recording}"\n[[sink]]\nkind = "crsd"\npath = "{direct}"\n')
        if received:
            file.write(f'[[sink]]\nkind = "vita49"\nprofile = "difi"\naddress = "{received.address}"\n')
    try:
        test_crsd.run(nereus, "run", scenario, "--pulses", f"0..{random_scenes.pulses(text, WAITING) if has_adc else 12}")
    finally:
        datagrams = received.end() if received else []
    test_crsd.run(nereus, "export", "crsd", recording, "--out", crsd)
    with open(crsd, "rb") as export, open(direct, "rb") as sink:
        assert export.read() == sink.read(), "sink and export differ"
    # With the two ends at one place sarkit divides by the sine of a bistatic angle of 0, and takes another value.
    with np.errstate(divide="ignore", invalid="ignore"):
        test_crsd.check_file(crsd)
    check_geometry(crsd)
    with h5py.File(recording) as h5:
        test_crsd.compare(h5, crsd)
        check_sigmf(nereus, recording, h5, base)
        if has_adc:
            check_difi(datagrams, h5)
    return family


def main():
    test_crsd.with_sarkit()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nereus", default=os.path.join(test_crsd.TOP, "target/debug/nereus"))
    parser.add_argument("--seed", type=int)
    args = parser.parse_args()
    if not os.path.exists(args.nereus):
        test_crsd.skip(f"no {args.nereus}: cargo build")
    factor = float(os.environ.get("NEREUS_CASES", "1"))
    count = len(random_scenes.FAMILIES) if factor < 1.0 else round(100 * factor)
    failed = []
    for seed in range(count) if args.seed is None else [args.seed]:
        folder = tempfile.mkdtemp(prefix="nereus-formats-")
        try:
            judge(args.nereus, folder, seed)
        except AssertionError as error:
            failed.append(seed)
            family = random_scenes.FAMILIES[seed % len(random_scenes.FAMILIES)]
            print(f"seed {seed}, {family}: {error!s:.2000}", flush=True)
        finally:
            shutil.rmtree(folder)
    print(f"{count if args.seed is None else 1} scenes as CRSD and SigMF, half of them as DIFI: {len(failed)} failed {failed or ''}".rstrip())
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
