#!/usr/bin/env python3
"""Draws docs/polarisation.svg: H and V of an isotropic antenna and of an aperture, by direction.

Usage: tools/polarisation_picture.py [OUT.svg]

Both bases are drawn from their definitions (docs/polarisation.md), as seen from the antenna, which looks along its level
boresight: on the left over azimuth and elevation all around, on the right over the direction cosines of the hemisphere ahead.
"""

import math
import sys
from pathlib import Path

H, V, INK, PALE = "#c0392b", "#2166ac", "#222222", "#bbbbbb"


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def local_horizontal(d):
    h = cross((0.0, 0.0, 1.0), d)
    length = math.sqrt(dot(h, h))
    h = tuple(c / length for c in h)
    return h, cross(d, h)


def ludwig3(d):
    """By theta from the boresight x and phi from y about it."""
    theta, phi = math.atan2(math.hypot(d[1], d[2]), d[0]), math.atan2(d[2], d[1])
    ct, st, cp, sp = math.cos(theta), math.sin(theta), math.cos(phi), math.sin(phi)
    of_theta, of_phi = (-st, ct * cp, ct * sp), (0.0, -sp, cp)
    h = tuple(cp * a - sp * b for a, b in zip(of_theta, of_phi))
    return h, tuple(sp * a + cp * b for a, b in zip(of_theta, of_phi))


class Picture:
    def __init__(self, width, height):
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
            'font-family="sans-serif" font-size="13">',
            f'<rect width="{width}" height="{height}" fill="white"/>',
        ]

    def line(self, a, b, colour, width=1.0, dash=""):
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<line x1="{a[0]:.1f}" y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}" stroke="{colour}" '
            f'stroke-width="{width}"{dashes}/>'
        )

    def arrow(self, at, by, colour):
        tip = (at[0] + by[0], at[1] + by[1])
        self.line(at, tip, colour, 1.6)
        length = math.hypot(*by)
        if length < 3:
            return
        u = (by[0] / length, by[1] / length)
        for side in (-1, 1):
            self.line(tip, (tip[0] - 4.5 * u[0] - side * 3 * u[1], tip[1] - 4.5 * u[1] + side * 3 * u[0]), colour, 1.6)

    def text(self, at, text, colour=INK, anchor="middle", size=13):
        self.parts.append(
            f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" fill="{colour}" text-anchor="{anchor}" font-size="{size}">{text}</text>'
        )

    def circle(self, at, radius, colour, dash=""):
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<circle cx="{at[0]}" cy="{at[1]}" r="{radius:.1f}" fill="none" stroke="{colour}"{dashes}/>'
        )

    def write(self, path):
        Path(path).write_text("\n".join([*self.parts, "</svg>"]) + "\n")


def seen(d, basis, to_page, at, scale):
    """Arrows of H and V at a direction: how its image moves, per radian, drawn to one length at the boresight."""
    for vector, colour in zip(basis(d), (H, V)):
        step = 1e-5
        moved = tuple(a + step * b for a, b in zip(d, vector))
        length = math.sqrt(dot(moved, moved))
        there = to_page(tuple(c / length for c in moved))
        yield ((there[0] - at[0]) / step * scale, (there[1] - at[1]) / step * scale), colour


def main(out):
    picture = Picture(900, 440)
    # Left: azimuth (to the left positive, as seen) and elevation.
    middle, per_deg = (225, 225), 1.15
    picture.text((225, 28), "isotropic: local-horizontal", size=15)

    def on_map(d):
        azimuth, elevation = math.degrees(math.atan2(d[1], d[0])), math.degrees(math.asin(d[2]))
        return (middle[0] - azimuth * per_deg, middle[1] - elevation * per_deg * 1.6)

    for elevation in (-90, 0, 90):
        y = middle[1] - elevation * per_deg * 1.6
        picture.line((middle[0] - 180 * per_deg, y), (middle[0] + 180 * per_deg, y), PALE, 1, "" if elevation == 0 else "4 3")
    picture.text((middle[0], middle[1] - 90 * per_deg * 1.6 - 8), "straight up: H turns with the azimuth", size=12)
    picture.text((middle[0], middle[1] + 90 * per_deg * 1.6 + 17), "straight down", size=12)
    picture.text((middle[0] + 4, middle[1] + 45), "nose", anchor="start", size=12)
    for azimuth in range(-150, 151, 60):
        for elevation in (-60, -30, 0, 30, 60):
            a, e = math.radians(azimuth), math.radians(elevation)
            d = (math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e))
            at = on_map(d)
            for vector, colour in zip(local_horizontal(d), (H, V)):
                # Along a circle of latitude and along a meridian: their lengths on this map are not those on the sphere.
                east = (-math.sin(a), math.cos(a), 0.0)
                north = (-math.sin(e) * math.cos(a), -math.sin(e) * math.sin(a), math.cos(e))
                picture.arrow(at, (-24 * dot(vector, east), -24 * dot(vector, north)), colour)
    for azimuth, name in ((90, "to port"), (-90, "to starboard")):
        picture.text((middle[0] - azimuth * per_deg, 424), name, size=12)
    # Right: direction cosines, left is y.
    centre, radius = (670, 225), 165
    picture.text((670, 28), "apertures and patterns: Ludwig's third definition", size=15)

    def on_disc(d):
        return (centre[0] - d[1] * radius, centre[1] - d[2] * radius)

    picture.circle(centre, radius, PALE)
    picture.circle(centre, radius * math.sin(math.radians(60)), INK, "4 3")
    picture.text((670, 424), "seen from the antenna; circles: 60 (dashed) and 90 degrees off the boresight", size=12)
    for theta in (0, 30, 60, 80):
        for phi in range(0, 360, 45) if theta else (0,):
            t, p = math.radians(theta), math.radians(phi)
            d = (math.cos(t), math.sin(t) * math.cos(p), math.sin(t) * math.sin(p))
            at = on_disc(d)
            for by, colour in seen(d, ludwig3, on_disc, at, 27 / radius):
                picture.arrow(at, by, colour)
    picture.text((centre[0] - 31, centre[1] + 14), "H", H)
    picture.text((centre[0] + 12, centre[1] - 18), "V", V)
    picture.text((centre[0] - radius - 12, centre[1] + 4), "y", INK, "end")
    picture.text((centre[0], centre[1] - radius - 8), "z")
    picture.write(out)


if __name__ == "__main__":
    default = Path(__file__).parent.parent / "docs" / "polarisation.svg"
    main(sys.argv[1] if len(sys.argv) > 1 else default)
