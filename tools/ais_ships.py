#!/usr/bin/env python3
"""Turn a recorded AIS log into [[ship]] tables of a scenario, on standard output.

Input: a CSV with the columns Time (UTC, ISO 8601), MMSI, Latitude_degrees, Longitude_degrees, COG_degrees,
SOG_knots. Of every vessel the report nearest to --utc, the start of the scenario, is taken and carried along its
course to that instant; from there the ship sails straight on. So a log serves runs over which courses are straight.

A log of this kind names neither type nor size: every vessel gets the same hull and length. Left out, and counted on
stderr, are
  - vessels without a report within --most-age-s of --utc;
  - vessels at rest: slower than --least-speed-mps over the ground (a ship at anchor raises no waves);
  - vessels whose course or speed is not available (360 degrees, 102.3 knots), or beyond 100 m/s;
  - vessels farther than --within-m from --lat-deg, --lon-deg.
Speed over the ground is taken for the speed through the water: currents are not known.

Standard library only. Exit 0 done, 2 the input is wrong.
"""

import argparse
import csv
import datetime
import json
import math
import sys

KNOT_MPS = 1852.0 / 3600.0
EARTH_RADIUS_M = 6371000.0
MOST_SPEED_MPS = 100.0
COLUMNS = ("Time", "MMSI", "Latitude_degrees", "Longitude_degrees", "COG_degrees", "SOG_knots")


class InputError(Exception):
    """The input cannot be used; the text says why."""


def parse_time(text):
    """ISO 8601 to an aware instant; without an offset it is UTC."""
    try:
        time = datetime.datetime.fromisoformat(text.strip().replace("Z", "+00:00"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text}: expected a UTC time such as 2016-01-12T13:05:00Z") from error
    return time if time.tzinfo else time.replace(tzinfo=datetime.timezone.utc)


def read_reports(path):
    """(time, MMSI, latitude, longitude, course, knots) of every row; a faulty row is an error with its line."""
    reports = []
    try:
        with open(path, encoding="utf-8", newline="") as file:
            rows = csv.DictReader(file)
            missing = [name for name in COLUMNS if name not in (rows.fieldnames or [])]
            if missing:
                raise InputError(f"{path}:1: no column {', '.join(missing)}; needed: {', '.join(COLUMNS)}")
            for row in rows:
                try:
                    time, mmsi, *numbers = (row[name] for name in COLUMNS)
                    lat, lon, course, knots = (float(number) for number in numbers)
                    report = (parse_time(time), int(mmsi), lat, lon, course, knots)
                except (TypeError, ValueError, AttributeError, argparse.ArgumentTypeError) as error:
                    raise InputError(f"{path}:{rows.line_num}: not a report: {error}") from error
                # 91 and 181 degrees say that the position is not known.
                if abs(lat) <= 90.0 and abs(lon) <= 180.0:
                    reports.append(report)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot read: {error}") from error
    return reports


def nearest(reports, instant):
    """The report of every vessel that is nearest to the instant, by MMSI."""
    found = {}
    for report in reports:
        age = abs((report[0] - instant).total_seconds())
        if report[1] not in found or age < found[report[1]][0]:
            found[report[1]] = (age, report)
    return {mmsi: report for mmsi, (_, report) in sorted(found.items())}


def carried(report, instant):
    """Latitude and longitude at the instant, along the course of the report."""
    time, _, lat, lon, course, knots = report
    way_m = knots * KNOT_MPS * (instant - time).total_seconds()
    north, east = way_m * math.cos(math.radians(course)), way_m * math.sin(math.radians(course))
    lat_there = lat + math.degrees(north / EARTH_RADIUS_M)
    lon_there = lon + math.degrees(east / (EARTH_RADIUS_M * math.cos(math.radians(lat))))
    return lat_there, lon_there


def distance_m(lat, lon, other_lat, other_lon):
    """Along the sphere, by the haversine."""
    phi, other_phi = math.radians(lat), math.radians(other_lat)
    half = math.sin((other_phi - phi) / 2) ** 2
    half += math.cos(phi) * math.cos(other_phi) * math.sin(math.radians(other_lon - lon) / 2) ** 2
    return 2 * EARTH_RADIUS_M * math.asin(min(1.0, math.sqrt(half)))


def sort_out(reports, options):
    """Ships as (MMSI, latitude, longitude, course, speed), and how many were left out why."""
    ships, left_out = [], {"old": 0, "unknown course or speed": 0, "at rest": 0, "far": 0}
    for mmsi, report in nearest(reports, options.utc).items():
        course, speed = report[4], report[5] * KNOT_MPS
        age_s = abs((report[0] - options.utc).total_seconds())
        lat, lon = carried(report, options.utc)
        centre = (options.lat_deg, options.lon_deg)
        if age_s > options.most_age_s:
            left_out["old"] += 1
        elif not (0.0 <= course < 360.0 and 0.0 <= speed <= MOST_SPEED_MPS and report[5] < 102.25):
            left_out["unknown course or speed"] += 1
        elif speed < options.least_speed_mps:
            left_out["at rest"] += 1
        elif options.within_m is not None and distance_m(lat, lon, *centre) > options.within_m:
            left_out["far"] += 1
        else:
            ships.append((mmsi, lat, lon, course, speed))
    return ships, left_out


def table(ship, options):
    """A [[ship]] table."""
    mmsi, lat, lon, course, speed = ship
    # A JSON string is a TOML one.
    lines = ["[[ship]]", f'name = "mmsi-{mmsi}"', f"hull = {json.dumps(options.hull)}"]
    lines.append(f"length_m = {options.length_m!r}")
    if options.hull == "wigley":
        lines += [f"beam_m = {options.beam_m!r}", f"draught_m = {options.draught_m!r}"]
    lines += [f"lat_deg = {lat:.7f}", f"lon_deg = {lon:.7f}"]
    lines += [f"heading_deg = {course!r}", f"speed_mps = {speed:.3f}"]
    return "\n".join(lines) + "\n"


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", help="AIS log, CSV")
    parser.add_argument("--utc", type=parse_time, required=True, help="start of the scenario: scene.start_utc")
    parser.add_argument("--hull", default="wigley", help='as in [[ship]]: "wigley" or a file; default: %(default)s')
    parser.add_argument("--length-m", type=float, default=60.0, help="default: %(default)s")
    parser.add_argument("--beam-m", type=float, default=10.0, help="wigley; default: %(default)s")
    parser.add_argument("--draught-m", type=float, default=3.5, help="wigley; default: %(default)s")
    parser.add_argument("--most-age-s", type=float, default=180.0, help="default: %(default)s")
    parser.add_argument("--least-speed-mps", type=float, default=0.5, help="default: %(default)s")
    parser.add_argument("--lat-deg", type=float, help="middle of the area")
    parser.add_argument("--lon-deg", type=float)
    parser.add_argument("--within-m", type=float, help="radius of the area; default: everywhere")
    options = parser.parse_args(arguments)
    try:
        area = [options.lat_deg, options.lon_deg, options.within_m]
        if None in area and area != [None] * 3:
            raise InputError("--lat-deg, --lon-deg and --within-m stand together or not at all")
        ships, left_out = sort_out(read_reports(options.log), options)
    except InputError as error:
        print(f"ais_ships: {error}", file=sys.stderr)
        return 2
    print("\n".join(table(ship, options) for ship in ships), end="")
    reasons = ", ".join(f"{count} {reason}" for reason, count in left_out.items() if count)
    print(f"{options.log}: {len(ships)} ships{'; left out: ' + reasons if reasons else ''}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
