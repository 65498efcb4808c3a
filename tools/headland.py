#!/usr/bin/env python3
"""Writes the raster of heights of `configs/coast.toml`: a headland of hills in closed form.

Usage: tools/headland.py [OUT]    (default configs/coast.tif)

Heights are 32-bit floats in metres, rounded to a quarter of one and deflated. Standard library alone.
"""

import math
import struct
import sys
import zlib

# First cell's north-western corner and steps, degrees: cells of 10 m at 54 degrees North.
WEST_DEG, NORTH_DEG = 9.990, 54.010
STEP_DEG = (1.53e-4, 0.9e-4)
COLUMNS, ROWS = 180, 180
METRES_A_DEGREE = 111_300.0
ORIGIN_DEG = (10.0, 54.0)

# Hills: East, North of the origin, m; height, m; radii along and across, m; angle of the first from East, degrees.
HILLS = (
    (250.0, 40.0, 46.0, 170.0, 80.0, 65.0),
    (380.0, 260.0, 58.0, 130.0, 110.0, 20.0),
    (150.0, -190.0, 24.0, 90.0, 60.0, -30.0),
    (520.0, 480.0, 70.0, 260.0, 160.0, 40.0),
)
# The sea floor that they stand on, m.
FLOOR_M = -14.0


def height_m(east_m, north_m):
    """Height above the sea at a place."""
    height = FLOOR_M
    for x, y, top, along, across, angle_deg in HILLS:
        cos, sin = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
        u = ((east_m - x) * cos + (north_m - y) * sin) / along
        v = ((north_m - y) * cos - (east_m - x) * sin) / across
        height += top * math.exp(-0.5 * (u * u + v * v))
    # Gullies, deeper where it is high.
    return height + 0.05 * max(height, 0.0) * math.sin(east_m / 23.0) * math.cos(north_m / 31.0)


def raster():
    """Heights row by row from the North, as little-endian floats."""
    narrow = math.cos(math.radians(ORIGIN_DEG[1]))
    data = bytearray()
    for row in range(ROWS):
        north_m = (NORTH_DEG - (row + 0.5) * STEP_DEG[1] - ORIGIN_DEG[1]) * METRES_A_DEGREE
        for column in range(COLUMNS):
            east_m = (WEST_DEG + (column + 0.5) * STEP_DEG[0] - ORIGIN_DEG[0]) * METRES_A_DEGREE * narrow
            # A quarter of a metre: as good as rasters are, and small when deflated.
            data += struct.pack("<f", round(4.0 * height_m(east_m, north_m)) / 4.0)
    return bytes(data)


def tiff(pixels):
    """A little-endian GeoTIFF of one strip, deflated."""
    packed = zlib.compress(pixels, 9)
    doubles = lambda *values: struct.pack(f"<{len(values)}d", *values)
    shorts = lambda *values: struct.pack(f"<{len(values)}H", *values)
    keys = (1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326)
    entries = (
        (256, 4, 1, struct.pack("<I", COLUMNS)),
        (257, 4, 1, struct.pack("<I", ROWS)),
        (258, 3, 1, shorts(32)),
        (259, 3, 1, shorts(8)),  # deflate
        (262, 3, 1, shorts(1)),
        (273, 4, 1, None),
        (277, 3, 1, shorts(1)),
        (278, 4, 1, struct.pack("<I", ROWS)),
        (279, 4, 1, struct.pack("<I", len(packed))),
        (339, 3, 1, shorts(3)),  # floats
        (33550, 12, 3, doubles(*STEP_DEG, 0.0)),
        (33922, 12, 6, doubles(0.0, 0.0, 0.0, WEST_DEG, NORTH_DEG, 0.0)),
        (34735, 3, len(keys), shorts(*keys)),
    )
    at = 8 + 2 + 12 * len(entries) + 4
    directory, beyond = struct.pack("<H", len(entries)), b""
    longer = sum(len(value) for *_, value in entries if value is not None and len(value) > 4)
    for tag, kind, count, value in entries:
        if value is None:
            value = struct.pack("<I", at + longer)
        elif len(value) > 4:
            beyond += value
            value = struct.pack("<I", at + len(beyond) - len(value))
        directory += struct.pack("<HHI", tag, kind, count) + value.ljust(4, b"\0")
    return b"II*\0" + struct.pack("<I", 8) + directory + struct.pack("<I", 0) + beyond + packed


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else "configs/coast.tif"
    with open(path, "wb") as file:
        file.write(tiff(raster()))


if __name__ == "__main__":
    main()
