#!/usr/bin/env python3
"""Does every sink get what a run counts, although the program is stopped again and again?

    tools/soak.py [--duration-s 3600] [--policy slip,stop,drop] [--prf-hz 200] [--seed 1] [--folder DIR] [--json]

For every policy, all at once, nereus releases a light scene in real time into a recording, to a receiver of its own (`nereus receive`, loopback)
and into a count. Meanwhile it is stopped (SIGSTOP) and continued (SIGCONT) at random instants. Stops last 2 to 20 s, and in runs below 10 minutes
a tenth to a fourth of a stretch of the run. All queues are short (--queue-pulses), so that a burst of overdue pulses would not fit. Then is held
against each other:

    released + dropped              the pulses of the scenario
    written + missed of each sink   released
    the recording                   read in full by `nereus verify`: whole, as many pulses as were written, missing ones between them counted
    the receiver                    complete pulses are those that were sent; those missing by number are those that were dropped
    slip, stop                      nothing dropped, nothing missed, exit 0
    drop                            what is missing is about what the stops lasted

Datagrams that this machine loses between the two programs are in the receiver's counts (`kernel_drops`); they fail the check, too.
Exit 0: all agree; 1: not; 2: cannot be run. Linux; needs no package.
"""
import argparse
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

PACKAGE = pathlib.Path(__file__).resolve().parent.parent
POLICIES = ("slip", "stop", "drop")

SCENE = """
[scene]
duration_s = {duration_s}
[radar]
carrier_hz = 10e9
sample_rate_hz = 100e6
prf_hz = {prf_hz}
channels = ["VV"]
[radar.waveform]
kind = "lfm"
bandwidth_hz = 60e6
pulse_s = 0.3e-6
[radar.window]
samples = 64
start_us = 20.0
[[platform]]
name = "mast"
track = {{ kind = "fixed", position_m = [0.0, 0.0, 30.0] }}
[[transmitter]]
name = "tx"
platform = "mast"
power_w = 100.0
antenna = {{ kind = "isotropic", gain_dbi = 30.0 }}
[[receiver]]
name = "rx"
platform = "mast"
antenna = {{ kind = "isotropic", gain_dbi = 30.0 }}
[[target]]
position_m = [3020.0, 0.0, 2.0]
rcs_m2 = 100.0
[stream]
policy = "{policy}"
threads = 1
[[sink]]
kind = "{kind}"
path = "{recording}"
queue_pulses = {queue_pulses}
[[sink]]
kind = "vita49"
address = "127.0.0.1:{port}"
queue_pulses = {queue_pulses}
[[sink]]
kind = "null"
queue_pulses = {queue_pulses}
"""


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


def last_line(text):
    """The object that a command prints last."""
    return json.loads(text.strip().splitlines()[-1])


def stops(duration_s, rng):
    """When the program is stopped, and for how long: about one stop in two minutes, three at least."""
    count = max(3, round(duration_s / 120))
    stretch = duration_s / count
    found = []
    for n in range(count):
        lasts = rng.uniform(2, 20) if duration_s >= 600 else stretch * rng.uniform(0.1, 0.25)
        # Not in the first second, while pulses are not released yet.
        found.append((max(1.0, n * stretch + rng.uniform(0.1, 0.4) * stretch), lasts))
    return found


def stop_and_go(child, plan, log):
    """Stops the run for as long as planned; the schedule is that of the wall clock."""
    begun = time.monotonic()
    for at, lasts in plan:
        time.sleep(max(0.0, begun + at - time.monotonic()))
        if child.poll() is not None:
            return
        os.kill(child.pid, signal.SIGSTOP)
        stopped = time.monotonic()
        time.sleep(lasts)
        os.kill(child.pid, signal.SIGCONT)
        log.append(time.monotonic() - stopped)


def soak(args, policy, folder, seed):
    """One policy: what was counted, and what does not agree."""
    port = free_port()
    kind, recording = ("plain", folder / f"{policy}.plain") if args.plain else ("hdf5", folder / f"{policy}.h5")
    scene = folder / f"{policy}.toml"
    scene.write_text(
        SCENE.format(
            duration_s=float(args.duration_s),
            prf_hz=float(args.prf_hz),
            policy=policy,
            kind=kind,
            recording=recording,
            port=port,
            queue_pulses=args.queue_pulses,
        ),
        encoding="utf-8",
    )
    log = []
    with open(folder / f"{policy}.receive.log", "w", encoding="utf-8") as said:
        receiver = subprocess.Popen(
            [args.nereus, "receive", "--listen", f"127.0.0.1:{port}", "--json"],
            stdout=subprocess.PIPE,
            stderr=said,
            text=True,
        )
        try:
            time.sleep(1.0)
            with open(folder / f"{policy}.run.log", "w", encoding="utf-8") as said_by_run:
                run = subprocess.Popen(
                    [args.nereus, "run", scene, "--json"], stdout=subprocess.PIPE, stderr=said_by_run, text=True
                )
            stopper = threading.Thread(target=stop_and_go, args=(run, stops(args.duration_s, random.Random(seed)), log))
            stopper.start()
            summary, _ = run.communicate()
            stopper.join()
            # What is on its way arrives.
            time.sleep(1.0)
        finally:
            receiver.send_signal(signal.SIGINT)
        received, _ = receiver.communicate(timeout=60)
    run_says, receiver_says = last_line(summary), last_line(received)
    verified = subprocess.run(
        [args.nereus, "verify", recording, "--json"], stdout=subprocess.PIPE, text=True, check=False
    )
    verdict = last_line(verified.stdout)
    if not args.keep:
        shutil.rmtree(recording, ignore_errors=True)
        recording.unlink(missing_ok=True)
    sinks = {sink["name"]: sink for sink in run_says["sinks"]}
    asked = round(args.duration_s * args.prf_hz)
    result = {
        "policy": policy,
        "exit": run.returncode,
        "error": run_says.get("error"),
        "stops": len(log),
        "stopped_s": sum(log),
        "elapsed_s": run_says["elapsed_s"],
        "asked": asked,
        **{key: run_says.get(key) for key in ("pulses", "late", "dropped", "missed", "slipped_s", "stood_still_s")},
        "sinks": {name: [sink["written"], sink["dropped"]] for name, sink in sinks.items()},
        "recording": {key: verdict[key] for key in ("whole", "pulses", "dropped", "faults")},
        "received": {
            **{key: receiver_says[key] for key in ("pulses", "incomplete", "kernel_drops")},
            "missing_by_index": receiver_says["missing"]["pulses_by_index"],
        },
    }
    result["faults"] = faults(result, sinks, verdict, receiver_says, args.prf_hz)
    return result


def faults(found, sinks, verdict, received, prf_hz):
    """What does not agree."""
    bad = []

    def agree(what, left, right):
        if left != right:
            bad.append(f"{what}: {left} and {right}")

    agree("released and dropped, and the pulses of the scenario", found["pulses"] + found["dropped"], found["asked"])
    for name, sink in sinks.items():
        agree(f"{name}, written and missed, and released", sink["written"] + sink["dropped"], found["pulses"])
    written = {name: sink["written"] for name, sink in sinks.items()}
    recording = next(name for name in written if name in ("hdf5", "plain"))
    agree("the recording, and what was written", verdict["pulses"], written[recording])
    agree("the recording, and whole", verdict["whole"], True)
    agree("received, and what was sent", received["pulses"], written["vita49"])
    between = received["last_pulse"] - received["first_pulse"] + 1 - received["pulses"]
    agree("missing by number at the receiver, and between its pulses", found["received"]["missing_by_index"], between)
    agree("incomplete at the receiver, and none", received["incomplete"], 0)
    if found["policy"] == "drop":
        # A stop shorter than what counts as stale is made up for; latency and a block more may go.
        most = (found["stopped_s"] + 1.0 * found["stops"]) * prf_hz
        if not 0 <= found["dropped"] <= most:
            bad.append(f"dropped {found['dropped']}, at most {most:.0f} were due while it was stopped")
    else:
        agree("exit code, and done", found["exit"], 0)
        agree("dropped, and none", found["dropped"], 0)
        agree("missed by sinks, and none", sum(sink["dropped"] for sink in sinks.values()), 0)
    return bad


def show(found):
    print(
        f"{found['policy']:5} exit {found['exit']}; stopped {found['stops']} times, {found['stopped_s']:.1f} s;"
        f" {found['asked']} pulses: {found['pulses']} released, {found['late']} late, {found['dropped']} dropped,"
        f" {found['missed']} missed; slipped {found['slipped_s']:.1f} s; {found['elapsed_s']:.1f} s"
    )
    for name, (written, missed) in found["sinks"].items():
        print(f"      {name:7} wrote {written}, missed {missed}")
    print(f"      recording {found['recording']}; receiver {found['received']}")
    if found["error"]:
        print(f"      error: {found['error']}")
    for fault in found["faults"]:
        print(f"      DOES NOT AGREE: {fault}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--duration-s", type=float, default=3600.0, help="of the scenario; stops are not in it under slip")
    parser.add_argument("--policy", default=",".join(POLICIES), help="one or more of " + ", ".join(POLICIES))
    parser.add_argument("--prf-hz", type=float, default=200.0)
    parser.add_argument("--queue-pulses", type=int, default=32, help="of every sink")
    parser.add_argument("--seed", type=int, default=1, help="of the stops")
    parser.add_argument("--plain", action="store_true", help="record into plain folders, not HDF5")
    parser.add_argument("--folder", type=pathlib.Path, help="for scenarios, logs and recordings; default: a temporary one")
    parser.add_argument("--keep", action="store_true", help="keep the recordings")
    parser.add_argument("--nereus", default=str(PACKAGE / "target/release/nereus"))
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    policies = args.policy.split(",")
    if not set(policies) <= set(POLICIES) or args.duration_s < 4:
        parser.error("--policy: some of slip,stop,drop; --duration-s: at least 4")
    own = None if args.folder else tempfile.TemporaryDirectory(prefix="nereus-soak-")
    folder = args.folder or pathlib.Path(own.name)
    folder.mkdir(parents=True, exist_ok=True)
    results, failed = {}, []

    def one(place, policy):
        try:
            results[policy] = soak(args, policy, folder, args.seed + place)
        except (OSError, ValueError, KeyError, TypeError, StopIteration, subprocess.SubprocessError) as error:
            failed.append(f"{policy}: {type(error).__name__}: {error}")

    threads = [threading.Thread(target=one, args=each) for each in enumerate(policies)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for line in failed:
        print(f"soak.py: {line}", file=sys.stderr)
    found = [results[policy] for policy in policies if policy in results]
    agree = not any(result["faults"] for result in found)
    if args.json:
        print(json.dumps({"agree": agree, "policies": found}))
    else:
        for result in found:
            show(result)
        print("all counts agree" if agree else "counts do NOT agree")
    if own:
        own.cleanup()
    return 2 if failed else 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
