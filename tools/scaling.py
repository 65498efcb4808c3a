#!/usr/bin/env python3
"""Efficiency of nereus.distributed on this machine: two worker processes of one thread against one process of two threads.

    tools/scaling.py [SCENARIO] [--duration-s S] [--workers N]

Both make the same Zarr store. Prints times on the wall and of the CPU (all processes), and the ratio of one process over
workers: the efficiency, 1 where distributing costs nothing. On a machine with other load only the CPU's ratio means something;
the load is printed. Needs the package nereus with its dask extra.
"""
import argparse
import os
import resource
import tempfile
import time

import nereus
from dask.distributed import Client, LocalCluster


def spent():
    """CPU seconds of this process and of its ended children."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(usage.ru_utime + usage.ru_stime for usage in map(resource.getrusage, kinds))


def measured(work):
    """Seconds on the wall and of the CPU."""
    begun, cpu = time.monotonic(), spent()
    wall = work()
    return wall or time.monotonic() - begun, spent() - cpu


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenario", nargs="?", default="configs/mars-1.toml")
    parser.add_argument("--duration-s", type=float, default=160.0)
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    scene = nereus.Scenario(args.scenario).set({"scene.duration_s": args.duration_s})
    with tempfile.TemporaryDirectory() as folder:

        def one():
            scene.set({"stream.threads": args.workers}).record(os.path.join(folder, "one.zarr"), progress=False)

        def many():
            # A cluster stands before a run, as one of Slurm does; its start is CPU time all the same.
            with LocalCluster(n_workers=args.workers, threads_per_worker=1, dashboard_address=None) as cluster:
                with Client(cluster) as client:
                    return nereus.distributed.record(scene, os.path.join(folder, "many.zarr"), client).seconds

        (wall, cpu), (wall_n, cpu_n) = measured(one), measured(many)
    print(f"{scene.pulse_count} pulses of {args.scenario}; load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    print(f"one process of {args.workers} threads: {wall:.1f} s, CPU {cpu:.1f} s")
    print(f"{args.workers} workers of one thread:   {wall_n:.1f} s, CPU {cpu_n:.1f} s")
    print(f"efficiency: wall {wall / wall_n:.2f}, CPU {cpu / cpu_n:.2f}")


if __name__ == "__main__":
    main()
