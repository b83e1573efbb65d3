"""Tissue surfaces: a hollow with an incision in its middle, as a height field, and its textures. Metres, +Y up."""
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "common"))
from example_common import png_file
from example_mesh import Mesh, grid_faces

HALF_M = 0.13  # of the square that the surface covers
CENTRE_SHARE = 0.4  # density of vertices and texels: 1 / 0.4 of the mean in the middle of the surface
INCISION_M = 0.017  # half of its length
FLESH, PALE, MUSCLE, VEIN, FAT = (np.array(c) for c in (
    (0.37, 0.080, 0.066), (0.55, 0.24, 0.195), (0.15, 0.010, 0.010), (0.15, 0.016, 0.028), (0.72, 0.44, 0.17)))


class Surface:
    """Shape of one tissue surface, in closed form."""

    def __init__(self, seed):
        self.seed = seed
        source = np.random.default_rng([seed, 1])
        lengths = np.repeat([0.085, 0.05, 0.032, 0.019, 0.011], 4)
        around = source.uniform(0, 2 * np.pi, len(lengths))
        self._waves = (2 * np.pi / lengths) * np.array([np.cos(around), np.sin(around)])
        self._phases = source.uniform(0, 2 * np.pi, len(lengths))
        self._amplitudes = 0.012 * lengths * source.uniform(0.5, 1.3, len(lengths))
        self._angle = source.uniform(0, np.pi)

    def incision(self, x, z):
        """Distance across and along from the middle of the incision, which is slightly bent."""
        c, s = np.cos(self._angle), np.sin(self._angle)
        along = c * x + s * z
        return -s * x + c * z + 0.0008 * np.sin(along / 0.0042 + self.seed), along

    def wound(self, x, z):
        """How deep in the incision a point is, and how near to its lips: both 0 to 1."""
        across, along = self.incision(x, z)
        inside = np.clip(1 - (along / INCISION_M) ** 4, 0, 1)
        width = 0.0005 + 0.0008 * np.sqrt(inside)
        return inside * np.exp(-(across / width) ** 2), inside * np.exp(-((np.abs(across) - 0.0024) / 0.0012) ** 2)

    def height(self, x, z):
        """Height in metres at points of equal shape."""
        x, z = np.asarray(x, float), np.asarray(z, float)
        waves = np.tensordot(self._amplitudes, np.sin(np.multiply.outer(self._waves[0], x) + np.multiply.outer(self._waves[1], z) +
                                                      self._phases.reshape(-1, *[1] * x.ndim)), 1)
        away = np.maximum(np.hypot(x, z) - 0.055, 0)
        deep, lips = self.wound(x, z)
        return waves + 9.0 * away ** 2 - 0.0017 * deep + 0.0005 * lips


def _warp(u):
    """Place in metres of a coordinate from -1 to 1: dense in the middle."""
    return HALF_M * (CENTRE_SHARE * u + (1 - CENTRE_SHARE) * u ** 3)


def _sample(values, u, v):
    """Bilinear; values (rows, columns) repeat. u: columns, v: rows, in cells."""
    rows, columns = values.shape
    i, j = np.floor(u).astype(int), np.floor(v).astype(int)
    a, b = u - i, v - j
    at = [values[(j + dj) % rows, (i + di) % columns] for dj in (0, 1) for di in (0, 1)]
    return (at[0] * (1 - a) + at[1] * a) * (1 - b) + (at[2] * (1 - a) + at[3] * a) * b


def _step(values, low, high):
    share = np.clip((values - low) / (high - low), 0, 1)
    return share * share * (3 - 2 * share)


def _mixed(colors, other, share):
    return colors + share[..., None] * (other - colors)


class Noise:
    """Smooth noise of standard deviation 1 that repeats after four of its largest bumps."""

    SIDE = 256

    def __init__(self, seed, tiles=8):
        source = np.random.default_rng([seed, 2])
        steps = np.fft.fftfreq(self.SIDE) * self.SIDE
        frequency = np.hypot(*np.meshgrid(steps, steps))
        band = np.where(frequency > 0, np.maximum(frequency, 4.0) ** -1.8, 0) * (frequency < 0.4 * self.SIDE)
        waves = np.fft.ifft2(np.fft.fft2(source.normal(size=(tiles, self.SIDE, self.SIDE))) * band).real
        self._tiles = waves / waves.std(axis=(1, 2), keepdims=True)

    def __call__(self, tile, size_m, x, z):
        return _sample(self._tiles[tile], self.SIDE / 4 * x / size_m, self.SIDE / 4 * z / size_m)


def _cells(seed, x, z, size_m):
    """Distance to the nearest and to the second nearest of points, one in each cell of a grid, in cells."""
    side = 64
    inside = np.random.default_rng([seed, 3]).uniform(0.1, 0.9, (side, side, 2))
    u, v = x / size_m, z / size_m
    i, j = np.floor(u).astype(int), np.floor(v).astype(int)
    nearest, second = np.full(x.shape, 9.0), np.full(x.shape, 9.0)
    for dj in (-1, 0, 1):
        for di in (-1, 0, 1):
            point = inside[(j + dj) % side, (i + di) % side]
            distance = np.hypot(i + di + point[..., 0] - u, j + dj + point[..., 1] - v)
            second = np.minimum(second, np.maximum(nearest, distance))
            nearest = np.minimum(nearest, distance)
    return nearest, second


VESSEL_HALF_M, VESSEL_TEXEL_M = 0.075, 0.00012


def _vessels(seed):
    """Raster of branching vessels, 0 to 1, about the middle of the surface."""
    source = np.random.default_rng([seed, 4])
    side = int(2 * VESSEL_HALF_M / VESSEL_TEXEL_M)
    raster = np.zeros((side, side), np.float32)
    ends = [(source.uniform(-1, 1, 2) * VESSEL_HALF_M, source.uniform(0, 2 * np.pi), source.uniform(0.0003, 0.0009)) for _ in range(13)]
    while ends:
        point, angle, radius = ends.pop()
        while radius > 0.00016 and np.abs(point).max() < VESSEL_HALF_M:
            reach = int(2 * radius / VESSEL_TEXEL_M) + 2
            column, row = ((point + VESSEL_HALF_M) / VESSEL_TEXEL_M).astype(int)
            rows, columns = (slice(max(at - reach, 0), at + reach + 1) for at in (row, column))
            part = raster[rows, columns]
            v, u = np.mgrid[rows.start:rows.start + part.shape[0], columns.start:columns.start + part.shape[1]] * VESSEL_TEXEL_M - VESSEL_HALF_M
            np.maximum(part, min(1, radius / 0.0004) * np.exp(-((u - point[0]) ** 2 + (v - point[1]) ** 2) / radius ** 2), out=part)
            if source.random() < 0.02:
                ends.append((point, angle + source.choice([-1, 1]) * source.uniform(0.4, 0.9), 0.7 * radius))
            angle += source.normal(0, 0.13)
            point = point + 0.0004 * np.array([np.cos(angle), np.sin(angle)])
            radius *= 0.9955
    return raster


def _normals(detail, steps):
    """Normal map of a height in metres; steps: metres from texel to texel, by column and by row."""
    across = np.gradient(detail, axis=1) / steps
    down = np.gradient(detail, axis=0) / steps[:, None]
    normal = np.dstack([-across, down, np.ones_like(detail)])  # glTF: +Y is up in the image
    return normal / np.linalg.norm(normal, axis=2, keepdims=True)


def _bytes(values):
    return np.round(255 * np.clip(values, 0, 1)).astype(np.uint8)


def textures(surface, side):
    """PNG files of side x side texels: base colour, roughness as glTF stores it, normals."""
    line = _warp((np.arange(side) + 0.5) / side * 2 - 1)
    x, z = np.meshgrid(line, line)
    noise, seed = Noise(surface.seed), surface.seed
    deep, lips = surface.wound(x, z)
    across, along = surface.incision(x, z)
    near = np.exp(-(across / 0.006) ** 2 - (along / (1.3 * INCISION_M)) ** 4)
    grain, fibres = noise(3, 0.0022, x, z), noise(5, 0.009, 1.5 * x + z, 0.25 * (z - 1.5 * x))
    vessel = np.where(np.maximum(np.abs(x), np.abs(z)) < VESSEL_HALF_M,
                      _sample(_vessels(seed), (x + VESSEL_HALF_M) / VESSEL_TEXEL_M, (z + VESSEL_HALF_M) / VESSEL_TEXEL_M), 0)
    nearest, second = _cells(seed, x + 0.0012 * noise(6, 0.012, x, z), z + 0.0012 * noise(7, 0.012, x, z), 0.0034)
    fat = _step(noise(2, 0.045, x, z) + 0.35 * noise(4, 0.007, x, z) - 1.2 * near, 0.9, 1.7)
    blood = _step(noise(1, 0.02, x, z) + 0.25 * noise(6, 0.006, x, z) + 1.8 * near, 1.7, 3.0)

    color = _mixed(FLESH * (1 + 0.10 * grain[..., None]), PALE, 0.55 * _step(noise(0, 0.03, x, z) + 0.5 * fibres, -0.6, 1.8))
    color = _mixed(color, VEIN, 0.75 * vessel * (1 - 0.6 * fat))
    color = _mixed(color, FAT * (0.62 + 0.30 * _step(second - nearest, 0.0, 0.4) + 0.12 * noise(5, 0.006, x, z))[..., None], 0.80 * fat)
    color = _mixed(_mixed(color, PALE, 0.5 * lips), MUSCLE, np.clip(1.6 * deep, 0, 1))
    color = _mixed(color, np.array([0.15, 0.004, 0.005]), 0.85 * blood)
    rough = np.clip(0.40 + 0.07 * noise(4, 0.01, x, z) - 0.04 * grain + 0.06 * fat, 0.22, 0.6) * (1 - blood) + 0.16 * blood
    detail = 1e-3 * (0.030 * fibres + 0.020 * grain + 0.07 * vessel + 0.40 * fat * (1 - nearest ** 2)) * (1 - 0.8 * blood)

    encoded = np.where(color <= 0.0031308, 12.92 * color, 1.055 * np.clip(color, 1e-6, 1) ** (1 / 2.4) - 0.055)
    return [png_file(_bytes(each)) for each in (encoded, np.dstack([np.ones_like(rough), rough, 0 * rough]),
                                                0.5 + 0.5 * _normals(detail, np.gradient(line)))]


def mesh(surface, cells):
    """Grid of cells x cells quads with texture coordinates."""
    u = np.linspace(-1, 1, cells + 1)
    x, z = np.meshgrid(_warp(u), _warp(u))
    step = 1e-5
    normal = np.dstack([surface.height(x - step, z) - surface.height(x + step, z), np.full_like(x, 2 * step),
                        surface.height(x, z - step) - surface.height(x, z + step)]).reshape(-1, 3)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    made = Mesh(np.dstack([x, surface.height(x, z), z]).reshape(-1, 3), normal, grid_faces(cells, cells)[:, ::-1])
    coordinates = np.dstack(np.meshgrid((u + 1) / 2, (u + 1) / 2)).reshape(-1, 2)
    made.attributes["TEXCOORD_0"] = coordinates, "<f4", "VEC2"
    return made
