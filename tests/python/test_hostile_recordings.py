#!/usr/bin/env python3
"""Damaged and forged recordings: every command that reads one ends by itself, with exit code 0, 1 or 2.

    tests/python/test_hostile_recordings.py [--runs 800] [--seed 19] [--nereus target/debug/nereus] [--only N]

Small recordings of every kind are made: float samples, converter codes, the two shards of a run, one whose writer was
killed, a plain folder. Each run damages a copy and reads it with a time limit and a memory limit. Damage: single bits,
bytes, blocks, lengths, truncation, foreign bytes behind; half of it where the file describes itself. A third of the
damage to those descriptions gets its checksum recomputed, as somebody who wants to do harm would. Everything follows
from the seed: the number of a run that failed makes it again (--only).

A run fails if the program is killed by a signal, panics (exit code 101), or needs longer than 30 s.
"""
import argparse
import collections
import os
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LIMIT_S = 30.0
MEMORY = 4 << 30
# What HDF5 calls its blocks: object headers and continuations, heaps, chunk indices.
SIGNATURES = [b"OHDR", b"OCHK", b"GCOL", b"EAHD", b"EAIB", b"EASB", b"EADB", b"FAHD", b"FADB",
              b"FRHP", b"FHDB", b"FHIB", b"BTHD", b"BTLF", b"BTIN", b"FSHD", b"TREE", b"SNOD", b"HEAP"]

SCENARIO = """
[scene]
duration_s = {duration_s}
seed = 5
[radar]
carrier_hz = 10e9
sample_rate_hz = 100e6
prf_hz = 400.0
channels = ["HH", "VV"]
noise_figure_db = 3.0
{adc}
waveform = {{ kind = "lfm", bandwidth_hz = 60e6, pulse_s = 2e-7 }}
window = {{ samples = 64, follow = {{ kind = "beside", platform = "plane", across_m = -3000.0, lead_us = 0.2 }} }}
[[platform]]
name = "plane"
track = {{ kind = "straight", position_m = [-22.0, -3000.0, 3000.0], velocity_mps = [222.0, 0.0, 0.0] }}
[[transmitter]]
name = "t"
platform = "plane"
power_w = 1000.0
antenna = {{ kind = "rectangle", width_m = 0.5, height_m = 0.1 }}
pointing = {{ kind = "beside", platform = "plane", across_m = -3000.0 }}
[[receiver]]
name = "r"
platform = "plane"
antenna = {{ kind = "ellipse", width_m = 0.5, height_m = 0.1 }}
pointing = {{ kind = "beside", platform = "plane", across_m = -3000.0 }}
[[target]]
name = "near"
position_m = [0.0, 0.0, 0.0]
rcs_m2 = 1000.0
[[sink]]
kind = "{kind}"
path = "{path}"
"""


def lookup3(data, value=0):
    """Checksum of HDF5's metadata: Bob Jenkins' lookup3, hashlittle."""
    mask = 0xFFFFFFFF
    a = b = c = (0xDEADBEEF + len(data) + value) & mask

    def rot(x, k):
        return ((x << k) | (x >> (32 - k))) & mask

    at = 0
    while len(data) - at > 12:
        x, y, z = struct.unpack_from("<III", data, at)
        a, b, c = (a + x) & mask, (b + y) & mask, (c + z) & mask
        a = (a - c) & mask ^ rot(c, 4); c = (c + b) & mask
        b = (b - a) & mask ^ rot(a, 6); a = (a + c) & mask
        c = (c - b) & mask ^ rot(b, 8); b = (b + a) & mask
        a = (a - c) & mask ^ rot(c, 16); c = (c + b) & mask
        b = (b - a) & mask ^ rot(a, 19); a = (a + c) & mask
        c = (c - b) & mask ^ rot(b, 4); b = (b + a) & mask
        at += 12
    tail = data[at:]
    if not tail:
        return c
    x, y, z = struct.unpack("<III", tail + bytes(12 - len(tail)))
    a, b, c = (a + x) & mask, (b + y) & mask, (c + z) & mask
    c ^= b; c = (c - rot(b, 14)) & mask
    a ^= c; a = (a - rot(c, 11)) & mask
    b ^= a; b = (b - rot(a, 25)) & mask
    c ^= b; c = (c - rot(b, 16)) & mask
    a ^= c; a = (a - rot(c, 4)) & mask
    b ^= a; b = (b - rot(a, 14)) & mask
    c ^= b; c = (c - rot(b, 24)) & mask
    return c


def summed(data):
    """Blocks with a checksum behind them whose length is known: (first byte, checksum's byte)."""
    found = []
    if data[:8] == b"\x89HDF\r\n\x1a\n" and data[8] in (2, 3):
        found.append((0, 44))
    at = data.find(b"OHDR")
    while at >= 0:
        flags = data[at + 5] if at + 6 <= len(data) else 0
        head = at + 6 + (16 if flags & 0x20 else 0) + (4 if flags & 0x10 else 0)
        width = 1 << (flags & 3)
        end = head + width + int.from_bytes(data[head:head + width], "little")
        if end + 4 <= len(data):
            found.append((at, end))
        at = data.find(b"OHDR", at + 4)
    at = data.find(b"EAHD")
    while at >= 0:
        if at + 72 <= len(data):
            found.append((at, at + 68))
        at = data.find(b"EAHD", at + 4)
    return [(first, last) for first, last in found
            if lookup3(bytes(data[first:last])) == int.from_bytes(data[last:last + 4], "little")]


def descriptions(data):
    """Bytes at which the file describes itself."""
    places = list(range(min(96, len(data))))
    for signature in SIGNATURES:
        at = data.find(signature)
        while at >= 0:
            places.extend(range(at, min(at + (4096 if signature == b"GCOL" else 400), len(data))))
            at = data.find(signature, at + 4)
    return places


def change(rng, data, at):
    """Changes one to eight bytes at a place."""
    kind = rng.randrange(5)
    if kind == 0:
        data[at] ^= 1 << rng.randrange(8)
    elif kind == 1:
        data[at] = rng.randrange(256)
    elif kind == 2:
        data[at] = rng.choice([0, 0x7F, 0x80, 0xFF])
    elif kind == 3:
        value = rng.choice([0, 1, 0xFFFFFFFF, 1 << 31, 1 << 40, (1 << 63) - 1, (1 << 64) - 1, 1 << 20])
        data[at:at + 8] = struct.pack("<Q", value)[:len(data) - at]
    else:
        value = rng.choice([0, 1, 0xFFFFFFFF, 0x7FFFFFFF, 1 << 16])
        data[at:at + 4] = struct.pack("<I", value)[:len(data) - at]


def damage(rng, data):
    """Damages the bytes of a file; what was done, in words."""
    data = bytearray(data)
    if not data:
        return data, "nothing to damage"
    kind = rng.choices(["forge", "describe", "bits", "bytes", "block", "truncate", "append"],
                       [25, 30, 12, 12, 8, 9, 4])[0]
    if kind == "forge":
        blocks = summed(data)
        if blocks:
            first, last = rng.choice(blocks)
            for _ in range(rng.randrange(1, 4)):
                change(rng, data, rng.randrange(first + 4, last))
            data[last:last + 4] = struct.pack("<I", lookup3(bytes(data[first:last])))
            return data, f"forged block {first}..{last}"
        kind = "describe"
    if kind == "describe":
        places = descriptions(data)
        for _ in range(rng.randrange(1, 6)):
            change(rng, data, rng.choice(places))
    elif kind == "bits":
        for _ in range(rng.choice([1, 1, 1, 8, 64])):
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    elif kind == "bytes":
        for _ in range(rng.choice([1, 16, 256])):
            data[rng.randrange(len(data))] = rng.randrange(256)
    elif kind == "block":
        at = rng.randrange(len(data))
        length = min(rng.choice([64, 512, 4096]), len(data) - at)
        data[at:at + length] = rng.choice([bytes(length), b"\xff" * length, rng.randbytes(length)])
    elif kind == "truncate":
        del data[rng.randrange(len(data)):]
    else:
        data += rng.randbytes(rng.randrange(1, 5000))
    return data, kind


def call(nereus, arguments, folder):
    """Runs the program under limits; how it ended, and its output."""
    def limits():
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.setsid()
    child = subprocess.Popen([nereus, *arguments], cwd=folder, preexec_fn=limits, stdin=subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        _, output = child.communicate(timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        os.killpg(child.pid, signal.SIGKILL)
        _, output = child.communicate()
        return "hang", output
    code = child.returncode
    if code < 0:
        return signal.Signals(-code).name, output
    return ("panic" if code == 101 else f"exit {code}"), output


def make(nereus, folder):
    """The recordings that are damaged: by name, the files of each."""
    def record(name, kind, adc="", more=(), duration_s=0.0999):
        with open(os.path.join(folder, "s.toml"), "w", encoding="utf-8") as out:
            out.write(SCENARIO.format(duration_s=duration_s, adc=adc, kind=kind, path=name))
        done = subprocess.run([nereus, "run", "s.toml", "--pace", "fast", *more], cwd=folder,
                              capture_output=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{name} cannot be recorded: {done.stderr.decode(errors='replace')}")
    codes = "adc = { bits = 14, full_scale_dbw = -80.0 }"
    kinds = {}
    if subprocess.run([nereus, "merge", "--help"], capture_output=True, check=False).returncode == 0:
        record("floats.h5", "hdf5")
        record("codes.h5", "hdf5", codes)
        # The path stands in the scenario that is recorded, and shards of different scenarios do not merge.
        record("shard.h5", "hdf5", "", ("--pulses", "0..20", "--out", "first.h5"))
        record("shard.h5", "hdf5", "", ("--pulses", "20..40", "--out", "second.h5"))
        # A writer that is killed leaves its mark.
        with open(os.path.join(folder, "s.toml"), "w", encoding="utf-8") as out:
            out.write(SCENARIO.format(duration_s=30, adc="", kind="hdf5", path="killed.h5"))
        child = subprocess.Popen([nereus, "run", "s.toml"], cwd=folder, stderr=subprocess.DEVNULL,
                                 stdout=subprocess.DEVNULL)
        begun = time.monotonic()
        while time.monotonic() - begun < 20 and not os.path.exists(os.path.join(folder, "killed.h5")):
            time.sleep(0.05)
        time.sleep(1.5)
        child.kill()
        child.wait()
        kinds.update(floats=["floats.h5"], codes=["codes.h5"], shards=["first.h5", "second.h5"],
                     killed=["killed.h5"])
    record("plain", "plain")
    kinds["plain"] = ["plain"]
    return kinds


def main():
    """Runs the cases and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    runs = max(1, round(120 * float(os.environ.get("NEREUS_CASES", "1"))))
    parser.add_argument("--runs", type=int, default=int(os.environ.get("NEREUS_HOSTILE_RUNS", runs)))
    parser.add_argument("--seed", type=int, default=19)
    parser.add_argument("--only", type=int, help="this run alone, and its output")
    parser.add_argument("--keep", help="folder for the files of runs that failed")
    parser.add_argument("--nereus", default=os.environ.get("NEREUS", os.path.join(TOP, "target/debug/nereus")))
    args = parser.parse_args()
    nereus = os.path.abspath(args.nereus)
    if not os.path.exists(nereus):
        print(f"no program at {nereus}: skipped (cargo build, or --nereus PATH)")
        return 0
    has_verify = subprocess.run([nereus, "verify", "--help"], capture_output=True, check=False).returncode == 0
    failed, tally = [], collections.Counter()
    with tempfile.TemporaryDirectory(prefix="nereus-hostile-") as folder:
        kinds = make(nereus, folder)
        names = ["floats", "floats", "codes", "shards", "killed", "plain"]
        names = [name for name in names if name in kinds]
        slowest = 0.0
        for number in range(args.runs) if args.only is None else [args.only]:
            rng = random.Random(args.seed * 1_000_003 + number)
            kind = names[number % len(names)]
            here = os.path.join(folder, "case")
            shutil.rmtree(here, ignore_errors=True)
            os.mkdir(here)
            for name in kinds[kind]:
                whole = os.path.join(folder, name)
                (shutil.copytree if os.path.isdir(whole) else shutil.copy)(whole, os.path.join(here, name))
            victim = os.path.join(here, rng.choice(kinds[kind]))
            if kind == "plain":
                files = [os.path.join(where, name) for where, _, held in os.walk(victim) for name in held]
                files.sort()
                victim = os.path.join(victim, "meta.json") if rng.random() < 0.5 else rng.choice(files)
            with open(victim, "rb") as held:
                data, done = damage(rng, held.read())
            with open(victim, "wb") as out:
                out.write(data)
            focus = ["focus", kinds[kind][0], "--centre-m", "0,0", "--size-m", "20", "--pixel-m", "2",
                     "--out", "p.png", "--force"]
            merge = ["merge", *kinds[kind], "--out", "all.h5", "--force"]
            verify = ["verify", kinds[kind][0]]
            choices = {"plain": [focus], "shards": [merge]}.get(kind, [focus, focus, merge])
            if has_verify:
                choices = [*choices, verify]
            command = rng.choice(choices)
            begun = time.monotonic()
            ended, output = call(nereus, command, here)
            took = time.monotonic() - begun
            slowest = max(slowest, took)
            tally[(kind, command[0], ended)] += 1
            good = ended in ("exit 0", "exit 1", "exit 2")
            if not good or args.only is not None:
                tail = output.decode(errors="replace").strip().splitlines()[-1:]
                print(f"run {number} ({kind}, {command[0]}, {done}, {os.path.basename(victim)}): {ended} {tail}")
            if not good:
                failed.append(number)
                if args.keep:
                    shutil.copytree(here, os.path.join(args.keep, str(number)), dirs_exist_ok=True)
    for (kind, command, ended), count in sorted(tally.items()):
        print(f"{kind:8} {command:7} {ended:10} {count:5}")
    print(f"{sum(tally.values())} runs, seed {args.seed}: {len(failed)} failed; the longest took {slowest:.2f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
