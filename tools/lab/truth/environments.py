"""Environment images of the reference scenes, latitude and longitude: rows from the zenith, the middle of a row is -Z."""
import numpy as np


def _directions(width, height):
    v, u = np.meshgrid((np.arange(height) + 0.5) / height, (np.arange(width) + 0.5) / width, indexing="ij")
    theta, phi = np.pi * v, 2 * np.pi * u
    return np.stack([-np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1), phi


def studio():
    """Sky, ground and a soft sun, in steps of 1/64 below 8, which halves and RGB9E5 hold exactly."""
    direction, phi = _directions(64, 32)
    up = direction[..., 1:2]
    sky = np.array([0.35, 0.5, 0.8]) * (1 - 0.5 * np.clip(up, 0, 1))
    ground = np.array([0.3, 0.25, 0.2]) * (1 + 0.4 * np.sin(3 * phi))[..., None]
    share = 1 / (1 + np.exp(-12 * up))
    sun = np.array([0.5, 0.7, 0.3])
    lobe = np.exp(40 * (direction @ (sun / np.linalg.norm(sun)) - 1))[..., None] * np.array([6.5, 6.0, 5.0])
    return np.round(np.clip(share * sky + (1 - share) * ground + lobe, 0, 7.9) * 64) / 64


def sunny():
    """A blue sky with a sun of 4 x 4 texels that gives three quarters of the light on level ground."""
    width, height = 512, 256
    direction, _ = _directions(width, height)
    up = direction[..., 1:2]
    pixels = np.where(up > 0, np.array([0.25, 0.4, 0.7]), np.array([0.15, 0.14, 0.12]))
    row, column = height * 45 // 180, width * 60 // 360
    texel_sr = 2 * np.pi / width * np.pi / height * np.sin(np.pi * row / height)
    sky_lx = np.pi * np.array([0.25, 0.4, 0.7])
    pixels[row:row + 4, column:column + 4] = 3 * sky_lx.mean() / (16 * texel_sr * np.cos(np.pi * row / height)) * np.array([1, 0.95, 0.85])
    return pixels


def white():
    return np.ones((4, 8, 3))
