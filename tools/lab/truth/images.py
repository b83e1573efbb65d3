"""Errors of linear images, and contact sheets. Images: float arrays of rows x columns x RGB, linear radiance."""
import struct
import zlib

import numpy as np

GAP = 4  # pixels between the tiles of a sheet
TILE = (128, 96)  # columns, rows


def png(pixels):
    """8-bit RGB PNG of rows x columns x 3."""
    height, width = pixels.shape[:2]
    rows = b"".join(b"\0" + row.tobytes() for row in np.ascontiguousarray(pixels, np.uint8))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def shown(linear, exposure):
    """sRGB values of 0 to 1."""
    clipped = np.clip(linear * exposure, 0, 1)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def errors(image, reference, level):
    """Difference of the means, and mean absolute difference; both relative to the radiance `level`."""
    difference = image - reference
    return difference.mean() / level, np.abs(difference).mean() / level


def heat(image, reference, level):
    """Black: equal; red, yellow, white: a third, two thirds and all of `level`, in steps of a 24th."""
    share = np.floor(24 * np.abs(image - reference).mean(axis=-1) / level) / 24
    return np.clip(3 * share[..., None] - np.array([0, 1, 2]), 0, 1)


def tile(image):
    """Nearest neighbours at the size of a tile."""
    rows = np.arange(TILE[1]) * image.shape[0] // TILE[1]
    columns = np.arange(TILE[0]) * image.shape[1] // TILE[0]
    return image[rows][:, columns]


def sheet(rows):
    """8-bit PNG of rows of images with values of 0 to 1; None leaves a tile white. Grey levels in steps of 4."""
    height, width, columns = TILE[1] + GAP, TILE[0] + GAP, max(map(len, rows))
    pixels = np.ones((len(rows) * height - GAP, columns * width - GAP, 3))
    for r, row in enumerate(rows):
        for c, image in enumerate(row):
            if image is not None:
                pixels[r * height:][:TILE[1], c * width:][:, :TILE[0]] = tile(image)
    return png((4 * np.rint(63.75 * pixels)).clip(0, 255).astype(np.uint8))
