#!/usr/bin/env python3
"""Convert recorded ADS-B rows (JSON records, gzipped or not) into a CSV track.

Input: a JSON array of objects with timestamp (ms since 1970, UTC), latitude, longitude (degrees) and
altitude (feet, pressure altitude). Output: time_utc,lat_deg,lon_deg,height_m, where height_m is the
PRESSURE altitude in metres (datum "barometric"). Nothing is smoothed or interpolated: rows are kept or
rejected, and every rejection is reported on stderr.

Rejected are
  - rows without a position, altitude or time, or out of range;
  - rows that repeat the time of the row before, or run backwards;
  - rows that repeat the position of the row before to the last digit although the aircraft moves
    (a stale position);
  - altitudes farther than --altitude-gate-m from the lines through the rows around them;
  - positions farther than --position-gate-m from there, beyond what a turn explains.

Standard library only. Exit 0 done, 2 the input is wrong.
"""

import argparse
import datetime
import gzip
import itertools
import json
import math
import os
import statistics
import sys

FOOT_M = 0.3048
EARTH_RADIUS_M = 6371000.0
TURN_MPS2 = 10.0  # acceleration of a steep turn
REACH = 4  # rows on either side that say where a row should be


class InputError(Exception):
    """The input cannot be used; the text says why."""


def read_rows(path):
    """The rows of a file, as dictionaries."""
    try:
        with open(path, "rb") as file:
            data = file.read()
        if data[:2] == b"\x1f\x8b":
            data = gzip.decompress(data)
        rows = json.loads(data)
    except OSError as error:
        raise InputError(f"{path}: cannot read: {error}") from error
    except (EOFError, ValueError) as error:
        raise InputError(f"{path}: not (gzipped) JSON: {error}") from error
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{path}: expected a JSON array of objects")
    return rows


def parse_time(text):
    """ISO 8601 UTC to milliseconds since 1970."""
    try:
        time = datetime.datetime.fromisoformat(text.removesuffix("Z"))
    except ValueError as error:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a UTC time such as 2018-05-30T18:40:00Z"
        ) from error
    return round(time.replace(tzinfo=datetime.timezone.utc).timestamp() * 1000)


def format_time(time_ms):
    """Milliseconds since 1970 to ISO 8601 UTC, exactly."""
    seconds, ms = divmod(time_ms, 1000)
    time = datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc)
    fraction = f".{ms:03d}" if ms else ""
    return time.strftime("%Y-%m-%dT%H:%M:%S") + fraction + "Z"


def number(value):
    """A finite number, or None."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return None
    return value


def clean(rows, start_ms, end_ms, altitude_gate_m, position_gate_m):
    """Fixes (time_ms, lat_deg, lon_deg, height_m) and what was rejected: a list of (time, reason)."""
    fixes, rejected = [], []
    for index, row in enumerate(rows):
        time = number(row.get("timestamp"))
        if time is None:
            rejected.append((f"row {index}", "no time"))
            continue
        time = round(time)
        if (start_ms is not None and time < start_ms) or (end_ms is not None and time > end_ms):
            continue
        lat, lon, altitude = (number(row.get(key)) for key in ("latitude", "longitude", "altitude"))
        if lat is None or lon is None or altitude is None:
            rejected.append((format_time(time), "no position or altitude"))
        elif not (-90 <= lat <= 90 and -180 <= lon <= 180):
            rejected.append((format_time(time), f"position {lat} {lon} out of range"))
        elif fixes and time <= fixes[-1][0]:
            rejected.append((format_time(time), f"not later than {format_time(fixes[-1][0])}"))
        elif fixes and (lat, lon) == fixes[-1][1:3] and (number(row.get("groundspeed")) or 0) > 5:
            rejected.append((format_time(time), "position repeated (stale)"))
        else:
            fixes.append((time, lat, lon, altitude * FOOT_M))

    kept = []
    for index, fix in enumerate(fixes):
        height_off = predicted(fixes, index, lambda f: f[3]) - fix[3]
        off = position_off_m(fixes, index)
        if abs(height_off) > altitude_gate_m:
            reason = f"altitude {fix[3]:.0f} m is {-height_off:+.0f} m off its neighbours"
            rejected.append((format_time(fix[0]), reason))
        elif off > position_gate_m:
            rejected.append((format_time(fix[0]), f"position is {off:.0f} m off its neighbours"))
        else:
            kept.append(fix)
    return kept, rejected


def predicted(fixes, index, value, reach=REACH):
    """Median of the lines through pairs of neighbours, at the time of a fix; its own value without any."""
    time = fixes[index][0]
    near = fixes[max(0, index - reach) : index] + fixes[index + 1 : index + 1 + reach]
    lines = [
        value(a) + (value(b) - value(a)) * (time - a[0]) / (b[0] - a[0])
        for a, b in itertools.combinations(near, 2)
    ]
    return statistics.median(lines) if lines else value(fixes[index])


def position_off_m(fixes, index):
    """How far a fix is from where its neighbours say, beyond what a turn explains, m.

    The smaller of two distances: from the lines through four neighbours on either side (not misled by one wrong
    neighbour), and from that through the next ones (not misled by a turn), less what TURN_MPS2 makes
    of the time between them.
    """
    if index == 0 or index == len(fixes) - 1:
        return 0.0
    _, lat, lon, _ = fixes[index]
    scale = math.radians(1.0) * EARTH_RADIUS_M

    def east(fix):  # the short way over the date line
        return ((fix[2] - lon + 180.0) % 360.0 - 180.0) * scale * math.cos(math.radians(lat))

    def north(fix):
        return (fix[1] - lat) * scale

    off = min(
        math.hypot(predicted(fixes, index, east, reach), predicted(fixes, index, north, reach))
        for reach in (1, REACH)
    )
    before_s, after_s = ((fixes[i + 1][0] - fixes[i][0]) / 1000 for i in (index - 1, index))
    return off - 0.5 * TURN_MPS2 * before_s * after_s


def write_track(path, fixes, comments):
    """The CSV track; a half-written file is never left behind."""
    partial = path + ".partial"
    try:
        with open(partial, "w", encoding="utf-8", newline="\n") as file:
            for comment in comments:
                file.write(f"# {comment}\n")
            file.write("time_utc,lat_deg,lon_deg,height_m\n")
            for time, lat, lon, height in fixes:
                file.write(f"{format_time(time)},{lat:.7f},{lon:.7f},{height:.2f}\n")
        os.replace(partial, path)
    except OSError as error:
        if os.path.exists(partial):
            os.remove(partial)
        raise InputError(f"{path}: cannot write: {error}") from error


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("input", help="JSON or JSON.gz of ADS-B rows")
    parser.add_argument("output", help="CSV track to write")
    parser.add_argument("--start", type=parse_time, metavar="UTC", help="first instant kept")
    parser.add_argument("--end", type=parse_time, metavar="UTC", help="last instant kept")
    parser.add_argument("--altitude-gate-m", type=float, default=150.0, help="default: %(default)s")
    parser.add_argument("--position-gate-m", type=float, default=300.0, help="default: %(default)s")
    parser.add_argument("--comment", action="append", default=[], help="comment line at the top")
    parser.add_argument("--force", action="store_true", help="overwrite the output")
    options = parser.parse_args(arguments)
    try:
        if options.start is not None and options.end is not None and options.start >= options.end:
            raise InputError(f"--start {format_time(options.start)} is not before --end {format_time(options.end)}")
        if os.path.exists(options.output) and not options.force:
            raise InputError(f"{options.output}: exists; give --force to overwrite it")
        rows = read_rows(options.input)
        fixes, rejected = clean(
            rows, options.start, options.end, options.altitude_gate_m, options.position_gate_m
        )
        if len(fixes) < 2:
            raise InputError(f"{options.input}: {len(fixes)} usable rows in that stretch; needed: at least 2")
        write_track(options.output, fixes, options.comment)
    except InputError as error:
        print(f"convert_adsb: {error}", file=sys.stderr)
        return 2
    for time, reason in rejected:
        print(f"rejected {time}: {reason}", file=sys.stderr)
    steps = [(b[0] - a[0]) / 1000 for a, b in zip(fixes, fixes[1:])]
    print(
        f"{options.output}: {len(fixes)} fixes, {format_time(fixes[0][0])} to {format_time(fixes[-1][0])}, "
        f"{len(rejected)} rows rejected, longest gap {max(steps):.0f} s",
        file=sys.stderr,
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
