#!/usr/bin/env python3
"""What a user would write instead: the raw echo of one pulse from its paths, in numpy and in Numba.

    tools/baseline.py [--config configs/mars-1.toml] [--pulse 250] [--counts 1000,10000,all] [--repeats 5] [--json]

1. `nereus snapshot CONFIG --pulse N --paths` writes the paths of a pulse: delays, rates, amplitudes of every channel.
2. `nereus run CONFIG --pulses N..N+1` records that pulse without noise and converter, with the scenario's own echo and with the reference.
3. The echo is made from the paths here, in several ways, and each is compared with both recordings.
4. Each way is timed on subsets of the same paths (median of several pulses), all channels at once, in f64.
5. `nereus bench CONFIG` measures what a whole pulse takes there, on patches of about as many facets.

The ways:

    numpy chirp      for every path the samples that its chirp touches, in chunks, added up by bincount
    numba chirp      the same as loops over paths and samples, on all cores or one, whichever is faster; the chirp is stepped by two complex products
    numba chirp x8   that at eight times the sample rate, then the receive filter
    numba grid       each path is spread over 5 cells of a grid twice as fine as the samples, which one FFT turns into the
                     spectrum (a nonuniform FFT of type 1); pulse, receive filter and kernel are dealt with there

A chirp that is sampled in time is not what a receiver records. A rectangular chirp is not band limited: of 60 MHz sampled at 100 MHz
one part in 107 (-20.3 dB) lies beyond half the sample rate. The receiver's anti-alias filter takes that away, sampling folds it into
the echo. So the plain chirps agree with a recording to some -20 dB, however right they are. At eight times the rate and filtered some
-40 dB are left; the grid, which has the filter exactly, agrees to its own error with the reference, and with the recording to that of
the fast echo.

Not the same work: the ways here begin with the paths, nereus makes the paths too (waves, shadows, antennas, scattering) and
receives. The ratio is that of the echo alone to a whole pulse of nereus, which flatters the ways here.

Needs numpy and h5py; numba is optional (pip install numba), without it the numba ways are left out.
Exit 0: done, and the grid agrees; 1: it does not; 2: something is missing.
"""
import argparse
import json
import math
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time
import tomllib

try:
    import h5py
    import numpy as np
except ImportError as missing:
    print(f"baseline.py: {missing}; install with: pip install numpy h5py", file=sys.stderr)
    sys.exit(2)

try:
    import numba
except ImportError:
    numba = None

PACKAGE = pathlib.Path(__file__).resolve().parent.parent
RINGING_SAMPLES = 32  # the receive filter rings beyond either end of a pulse
OVERSAMPLING = 2
WIDTH = 5  # cells of the kernel
BETA = 2.30 * WIDTH
GRID_LIMIT_DB = -60.0


class Paths:
    """What `nereus snapshot --paths` writes; the pair of all channels must be the same."""

    def __init__(self, path):
        with h5py.File(path, "r") as file:
            a = file.attrs
            if a["waveform"] != "lfm":
                raise ValueError("only linear sweeps are made here")
            if len(np.unique(file["channel_pair"][:])) != 1:
                raise ValueError("channels of several pairs of antennas: only one pair is made here")
            pair = int(file["channel_pair"][0])
            self.f0, self.fs = float(a["carrier_hz"]), float(a["sample_rate_hz"])
            self.bandwidth, self.pulse_s = float(a["bandwidth_hz"]), float(a["pulse_s"])
            self.mu = (1 if a["sweep"] == "up" else -1) * self.bandwidth / self.pulse_s
            self.samples = int(a["samples"])
            self.channels = [str(name) for name in a["channels"]]
            tau = file["delay_s"][pair]
            self.rate = file["delay_rate"][pair]
            # Seconds after the first sample, and the amplitude with the phase of the way: f0 tau is some 3e5 turns.
            self.after = file["emission_offset_s"][:] + tau - float(a["window_start_s"])
            phasor = np.exp(-2j * np.pi * np.mod(self.f0 * tau, 1.0))
            self.amplitude = np.ascontiguousarray((file["amplitude"][:] * phasor).T)  # [path, channel]

    def __len__(self):
        return len(self.after)

    def some(self, count, seed=1):
        """A random subset, in the order of the list."""
        other = object.__new__(Paths)
        other.__dict__.update(self.__dict__)
        if count < len(self):
            these = np.sort(np.random.default_rng(seed).choice(len(self), count, replace=False))
            other.after, other.rate = self.after[these], self.rate[these]
            other.amplitude = self.amplitude[these]
        return other


# ---------------------------------------------------------------- the chirp in time


def numpy_chirp(c, chunk=16384):
    """s[j] = sum_n a_n exp(-j 2 pi f0 tau_n) p(t) exp(-j 2 pi f0 r_n t), t = j/fs - after_n, 0 <= t < Tc."""
    touched = math.ceil(c.pulse_s * c.fs)
    out = np.zeros((len(c.channels), c.samples), complex)
    for begin in range(0, len(c), chunk):
        part = slice(begin, begin + chunk)
        after, rate = c.after[part], c.rate[part]
        first = np.ceil(after * c.fs).astype(np.int64)
        j = first[:, None] + np.arange(touched)
        t = j / c.fs - after[:, None]
        here = (j >= 0) & (j < c.samples) & (t < c.pulse_s)
        u = t - c.pulse_s / 2
        chirp = np.exp(1j * np.pi * (c.mu * u * u - 2 * c.f0 * rate[:, None] * t))[here]
        cell, row = j[here], np.nonzero(here)[0]
        for channel, a in enumerate(c.amplitude[part].T):
            echo = a[row] * chirp
            out[channel] += np.bincount(cell, echo.real, c.samples)
            out[channel] += 1j * np.bincount(cell, echo.imag, c.samples)
    return out


def compiled(parallel):
    """The loops of the numba ways."""
    jit = numba.njit(parallel=parallel, fastmath=True, nogil=True)

    @jit
    def chirps(after, rate, amplitude, f0, fs, mu, pulse_s, samples, threads):
        count, channels = amplitude.shape
        sums = np.zeros((threads, samples, channels), np.complex128)
        for worker in numba.prange(threads):
            own = sums[worker]
            for n in range(count * worker // threads, count * (worker + 1) // threads):
                first = max(0, math.ceil(after[n] * fs))
                last = min(samples, math.ceil((after[n] + pulse_s) * fs))
                t = first / fs - after[n]
                # A quadratic phase is stepped by a step that is stepped.
                u, dt = t - pulse_s / 2, 1 / fs
                phase = math.pi * (mu * u * u - 2 * f0 * rate[n] * t)
                turn = math.pi * (mu * dt * (2 * u + dt) - 2 * f0 * rate[n] * dt)
                more = 2 * math.pi * mu * dt * dt
                p = complex(math.cos(phase), math.sin(phase))
                step = complex(math.cos(turn), math.sin(turn))
                bend = complex(math.cos(more), math.sin(more))
                for j in range(first, last):
                    for channel in range(channels):
                        own[j, channel] += amplitude[n, channel] * p
                    p *= step
                    step *= bend
        return sums

    @jit
    def spread(place, weight, width, beta, cells, threads):
        count, channels = weight.shape
        grids = np.zeros((threads, cells, channels), np.complex128)
        for worker in numba.prange(threads):
            own = grids[worker]
            kernel = np.empty(width)
            for n in range(count * worker // threads, count * (worker + 1) // threads):
                first = math.ceil(place[n] - width / 2)
                for tap in range(width):
                    x = (first + tap - place[n]) / (width / 2)
                    kernel[tap] = math.exp(beta * (math.sqrt(max(0.0, 1 - x * x)) - 1))
                for tap in range(width):
                    cell = (first + tap) % cells
                    for channel in range(channels):
                        own[cell, channel] += weight[n, channel] * kernel[tap]
        return grids

    return chirps, spread


def numba_chirp(loops, c, threads):
    sums = loops[0](c.after, c.rate, c.amplitude, c.f0, c.fs, c.mu, c.pulse_s, c.samples, threads)
    return sums.sum(axis=0).T


def numba_chirp_filtered(loops, grid, c, threads, times=8):
    after, samples = c.after + RINGING_SAMPLES / c.fs, times * grid.length
    sums = loops[0](after, c.rate, c.amplitude, c.f0, times * c.fs, c.mu, c.pulse_s, samples, threads)
    spectrum = np.fft.fft(sums.sum(axis=0), axis=0)[grid.bins] * (grid.filter / times)[:, None]
    return np.fft.ifft(spectrum, axis=0)[RINGING_SAMPLES : RINGING_SAMPLES + c.samples].T


# ---------------------------------------------------------------- the grid


def fast_length(least):
    """The least length of factors 2, 3 and 5."""
    while True:
        rest = least
        for prime in (2, 3, 5):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return least
        least += 1


class Grid:
    """What does not depend on the paths but on their mean rate."""

    def __init__(self, c):
        self.length = fast_length(c.samples + math.ceil(c.pulse_s * c.fs) + 2 * RINGING_SAMPLES)
        self.cells = OVERSAMPLING * self.length
        f = np.fft.fftfreq(self.length, 1 / c.fs)
        self.bins = np.rint(f * self.length / c.fs).astype(int)  # negative ones from the end
        share = np.abs(f) / c.fs
        edge = 0.5 * (1 + np.cos(10 * np.pi * (share - 0.4)))
        self.filter = np.where(share <= 0.4, 1.0, np.where(share < 0.5, edge, 0.0))
        # The mean Doppler is in the pulse, whose spectrum is a quadrature: 4 turns to 32 nodes.
        self.rate = np.average(c.rate, weights=np.sum(np.abs(c.amplitude) ** 2, axis=1))
        panels = math.ceil((c.bandwidth + c.fs) * c.pulse_s / 4)
        node, weight = np.polynomial.legendre.leggauss(32)
        edges = np.linspace(0, c.pulse_s, panels + 1)
        half = np.diff(edges) / 2
        t = (edges[:-1, None] + half[:, None] * (1 + node)).ravel()
        u = t - c.pulse_s / 2
        chirp = (half[:, None] * weight).ravel() * np.exp(
            1j * np.pi * (c.mu * u * u - 2 * c.f0 * self.rate * t)
        )
        pulse = np.exp(-2j * np.pi * np.multiply.outer(f, t)) @ chirp
        # The spectrum of the kernel, likewise.
        x, weight = np.polynomial.legendre.leggauss(64)
        kernel = WIDTH / 2 * weight * np.exp(BETA * (np.sqrt(1 - x * x) - 1))
        kernel = np.cos(np.pi * WIDTH / self.cells * np.multiply.outer(self.bins, x)) @ kernel
        self.replica = c.fs * pulse * self.filter / kernel


def numba_grid(loops, grid, c, threads):
    # Of a sweep, Doppler off the mean is a delay and a phase, but for the ends of the pulse:
    # p(t) exp(-j 2 pi f t) = p(t - f/mu) exp(-j pi f (Tc + f/mu)).
    f = c.f0 * (c.rate - grid.rate)
    shift = f / c.mu
    received = c.after > -c.pulse_s - RINGING_SAMPLES / c.fs
    received &= c.after < (c.samples + RINGING_SAMPLES) / c.fs
    turns = 0.5 * f * (c.pulse_s + shift) + c.f0 * grid.rate * shift
    weight = c.amplitude * (np.exp(-2j * np.pi * turns) * received)[:, None]
    place = (c.after + shift) * (c.fs * OVERSAMPLING)
    grids = loops[1](place, weight, WIDTH, BETA, grid.cells, threads)
    spectrum = np.fft.fft(grids.sum(axis=0), axis=0)[grid.bins] * grid.replica[:, None]
    return np.fft.ifft(spectrum, axis=0)[: c.samples].T


# ---------------------------------------------------------------- nereus


def program(given):
    """The command that runs nereus."""
    found = pathlib.Path(given) if given else PACKAGE / "target/release/nereus"
    if not found.exists():
        print(f"baseline.py: no {found}; build it: cargo build --release, or name it: --nereus", file=sys.stderr)
        sys.exit(2)
    return [str(found)]


def noiseless(path, folder):
    """A copy of a scenario without noise and converter, which nobody can predict; its files stay where they are."""
    here, kept, converter = pathlib.Path(path).resolve().parent, [], False

    def absolute(match):
        file = here / match.group(3)
        return f"{match.group(1)}{json.dumps(str(file))}" if file.is_file() else match.group(0)

    for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            converter = line.split("#")[0].strip() == "[radar.adc]"
        if not converter and not re.match(r"(noise_figure_db|adc)\s*=", line):
            kept.append(re.sub(r"(\b(path|hull|state_path)\s*=\s*)\"([^\"]*)\"", absolute, line))
    copy = pathlib.Path(folder) / "scenario.toml"
    copy.write_text("\n".join(kept) + "\n", encoding="utf-8")
    return str(copy)


def call(command):
    ended = subprocess.run(command, capture_output=True, text=True)
    if ended.returncode != 0:
        print(f"baseline.py: {' '.join(map(str, command))}\n{ended.stderr.strip()}", file=sys.stderr)
        sys.exit(2)
    return ended.stdout


def bench(nereus, config, settings, facet_m, count, patch_m):
    """Seconds of a whole pulse on a square patch of about `count` facets; the scenario's own patch for None."""
    sized = []
    if count is not None:
        side = min(max(2, 2 * round(math.sqrt(count) / 2)) * facet_m, *patch_m)
        sized = ["--set", f"scene.patch_size_m=[{side}, {side}]"]
    measured = json.loads(call([*nereus, "bench", config, *settings, *sized, "--error-pulses", "0", "--json"]))
    return {
        "paths": measured["paths"],
        "seconds": 1 / measured["pulses_per_s"],
        "threads": measured["threads"],
        "prf_s": measured["real_time_factor"] / measured["pulses_per_s"],
    }


# ---------------------------------------------------------------- the table


def timed(make, repeats):
    make()  # compiles, warms the caches
    spent = []
    for _ in range(repeats):
        begun = time.perf_counter()
        make()
        spent.append(time.perf_counter() - begun)
    return statistics.median(spent)


def relative_db(found, want):
    """Of the worst channel that holds anything, 20 log10(||found - want||/||want||)."""
    worst = -400.0
    for a, b in zip(found, want):
        level, apart = np.linalg.norm(b), np.linalg.norm(a - b)
        if level > 0:
            worst = max(worst, 20 * math.log10(max(apart / level, 1e-20)))
    return worst


def machine():
    name = ""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            name = next((line.split(":")[1].strip() for line in file if line.startswith("model name")), "")
    except OSError:
        pass
    versions = f"Python {sys.version.split()[0]}, numpy {np.__version__}"
    versions += f", numba {numba.__version__}" if numba else ", no numba"
    return f"{os.cpu_count()} cores {name}; {versions}".replace("  ", " ")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--config", default=str(PACKAGE / "configs/mars-1.toml"))
    parser.add_argument("--pulse", type=int, help="[default: the middle one of mars-1, 250; else 0]")
    parser.add_argument("--counts", default="1000,10000,all", help="paths; all: every one of the pulse")
    parser.add_argument("--repeats", type=int, default=5, help="the median of so many is reported")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as of nereus")
    parser.add_argument("--nereus", help="the program [default: target/release/nereus]")
    parser.add_argument("--no-bench", action="store_true", help="leave nereus bench out")
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    nereus = program(args.nereus)
    settings = [word for setting in args.set for word in ("--set", setting)]
    index = args.pulse
    if index is None:
        index = 250 if pathlib.Path(args.config).stem == "mars-1" else 0
    with tempfile.TemporaryDirectory() as folder:
        paths, recording = f"{folder}/paths.h5", f"{folder}/pulse.h5"
        quiet = noiseless(args.config, folder)
        call([*nereus, "snapshot", quiet, *settings, "--pulse", str(index), "--paths", paths])
        span = f"{index}..{index + 1}"
        run = ["run", quiet, *settings, "--pace", "fast", "--pulses", span, "--out", recording]
        call([*nereus, *run])
        call([*nereus, *run[:-1], f"{folder}/exact.h5", "--set", "fidelity.echo=reference"])
        try:
            whole = Paths(paths)
        except ValueError as error:
            print(f"baseline.py: {args.config}: {error}", file=sys.stderr)
            return 2
        with h5py.File(recording, "r") as fast, h5py.File(f"{folder}/exact.h5", "r") as exact:
            recorded, reference = fast["iq"][0].astype(complex), exact["iq"][0].astype(complex)
            scene = tomllib.loads(fast.attrs["config"])["scene"]

    ways = {"numpy chirp": [numpy_chirp]}
    if numba:
        grid = Grid(whole)
        all_cores, one_core = (compiled(True), numba.get_num_threads()), (compiled(False), 1)
        for name, make in (
            ("numba chirp", lambda c, loops, threads: numba_chirp(loops, c, threads)),
            ("numba chirp x8", lambda c, loops, threads: numba_chirp_filtered(loops, grid, c, threads)),
            ("numba grid", lambda c, loops, threads: numba_grid(loops, grid, c, threads)),
        ):
            ways[name] = [lambda c, make=make, of=of: make(c, *of) for of in (all_cores, one_core)]
    errors = {}
    for name, makes in ways.items():
        made = [make(whole) for make in makes]
        errors[name] = [max(relative_db(one, other) for one in made) for other in (recorded, reference)]

    counts = [len(whole) if word == "all" else int(word) for word in args.counts.split(",")]
    counts = sorted({min(count, len(whole)) for count in counts})
    seconds = {}
    for count in counts:
        some = whole.some(count)
        # Waking the other cores takes longer than a few paths: the faster of one core and all.
        seconds[count] = {
            name: min(timed(lambda make=make: make(some), args.repeats) for make in makes)
            for name, makes in ways.items()
        }
    pulses = {}
    if not args.no_bench:
        facet_m, patch_m = scene.get("facet_m"), scene.get("patch_size_m")
        for count in counts:
            size = None if count == len(whole) or facet_m is None else count
            pulses[count] = bench(nereus, args.config, settings, facet_m, size, patch_m)

    result = {
        "config": args.config,
        "pulse": index,
        "paths": len(whole),
        "channels": whole.channels,
        "machine": machine(),
        "error_db": {name: {"recorded": a, "reference": b} for name, (a, b) in errors.items()},
        "seconds": {str(count): times for count, times in seconds.items()},
        "nereus": {str(count): measured for count, measured in pulses.items()},
    }
    sound = "numba grid" not in errors or errors["numba grid"][1] <= GRID_LIMIT_DB
    if args.json:
        print(json.dumps(result | {"sound": sound}, allow_nan=False))
        return 0 if sound else 1
    show(args, result, errors, seconds, pulses)
    return 0 if sound else 1


def show(args, result, errors, seconds, pulses):
    print(f"{args.config}, pulse {result['pulse']}: {result['paths']} paths, {len(result['channels'])} channels")
    print(result["machine"])
    if not numba:
        print("numba is absent: pip install numba adds two ways")
    print("\nagainst the samples that nereus recorded, worst channel, dB (fast echo; reference echo)")
    for name, (fast, exact) in errors.items():
        print(f"  {name:15} {fast:7.1f} {exact:7.1f}")
    print("\nms a pulse, all channels; in brackets times of a whole pulse of nereus, its paths regenerated")
    names = list(errors)
    print("  " + f"{'paths':>9}" + "".join(f"{name:>22}" for name in names) + f"{'nereus, whole pulse':>24}")
    for count, times in seconds.items():
        row = f"  {count:9}"
        measured = pulses.get(count)
        for name in names:
            ratio = f"({times[name] / measured['seconds']:.1f} x)" if measured else ""
            row += f"{1e3 * times[name]:11.2f} {ratio:>10}"
        if measured:
            row += f"{1e3 * measured['seconds']:11.2f} of {measured['paths']}"
        print(row)
    if pulses:
        prf_s = next(iter(pulses.values()))["prf_s"]
        print(f"\nreal time is {1e3 * prf_s:.3f} ms a pulse")


if __name__ == "__main__":
    sys.exit(main())
