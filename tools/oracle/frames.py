"""Vectors, rotations, geodetic places, polarisation bases. Arrays of vectors are [n, 3], of matrices [n, 3, 3]."""

import math

import numpy as np

C = 299_792_458.0
EARTH_RADIUS_M = 6_371_000.0
UP = np.array([0.0, 0.0, 1.0])


class Unfit(Exception):
    """The recording cannot be judged."""


def dot(a, b):
    return np.sum(a * b, axis=-1)


def unit(x):
    return x / np.linalg.norm(x, axis=-1, keepdims=True)


def split(x):
    """Directions and lengths."""
    length = np.linalg.norm(x, axis=-1)
    return x / length[:, None], length


def turn(matrices, vectors):
    """Matrix times vector, either of them one for all."""
    return np.matmul(matrices, vectors[..., None])[..., 0]


def local_up(place, radius):
    """Away from the centre of an earth of this radius, which may be infinite."""
    return unit(UP + place / radius)


def rx(a):
    return np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])


def ry(a):
    return np.array([[math.cos(a), 0, math.sin(a)], [0, 1, 0], [-math.sin(a), 0, math.cos(a)]])


def rz(a):
    return np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])


def matrix(q):
    """Rotation matrices of Hamilton quaternions [n, 4], scalar first."""
    w, x, y, z = np.moveaxis(unit(q), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def ecef(lat_deg, lon_deg, h):
    a, f = 6378137.0, 1 / 298.257223563
    e2 = f * (2 - f)
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    n = a / math.sqrt(1 - e2 * math.sin(lat) ** 2)
    r = (n + h) * math.cos(lat)
    return np.array([r * math.cos(lon), r * math.sin(lon), (n * (1 - e2) + h) * math.sin(lat)])


def enu(lat_deg, lon_deg):
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    sa, ca, so, co = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
    return np.array([[-so, co, 0], [-sa * co, -sa * so, ca], [ca * co, ca * so, sa]])


def basis(k, normal=UP):
    """v and h of propagation directions, over the horizon or over facets of these normals."""
    h = np.cross(normal, k)
    norm = np.linalg.norm(h, axis=-1, keepdims=True)
    h = np.where(norm < 1e-12, np.array([0.0, 1.0, 0.0]), h / np.where(norm < 1e-12, 1.0, norm))
    return np.cross(h, k), h
