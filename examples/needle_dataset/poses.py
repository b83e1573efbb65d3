"""Errors of 6D poses as BOP defines them, by NumPy alone. Rotations (..., 3, 3) and translations (..., 3) lead from the
model to the camera; translations and points share one unit of length."""
import numpy as np


def rotation_error_deg(estimated, true):
    """Angle between two rotations."""
    difference = np.asarray(estimated) - np.asarray(true)
    half = np.linalg.norm(difference, axis=(-2, -1)) / np.sqrt(8)  # of the angle, its sine: exact for small angles, too
    return np.degrees(2 * np.arcsin(np.clip(half, 0, 1)))


def translation_error(estimated, true):
    return np.linalg.norm(np.asarray(estimated) - np.asarray(true), axis=-1)


def transformed(rotation, translation, points):
    """Points (n, 3) by poses: (..., n, 3)."""
    return points @ np.swapaxes(rotation, -1, -2) + np.asarray(translation)[..., None, :]


def needle_symmetries():
    """Rotations (s, 3, 3) that map the needle's shape onto itself: none, and half a turn that exchanges tip and tail. In BOP's
    sense: surfaces then differ by less than a tenth of the diameter. The thread tells the two apart."""
    return np.array([np.eye(3), np.diag([-1.0, 1.0, -1.0])])


def mssd(rotation, translation, true_rotation, true_translation, points, symmetries=None):
    """Maximum symmetry-aware surface distance: the least, over symmetries of the model, of the largest distance of a point."""
    estimated = transformed(rotation, translation, points)
    found = []
    for symmetry in np.eye(3)[None] if symmetries is None else symmetries:
        wanted = transformed(np.asarray(true_rotation) @ symmetry, true_translation, points)
        found.append(np.linalg.norm(estimated - wanted, axis=-1).max(-1))
    return np.min(found, axis=0)


def table(rotation, translation, true_rotation, true_translation, points):
    """Rows of (name, unit, median, mean) over all poses, (n, ...); millimetres."""
    angles = [rotation_error_deg(rotation, true_rotation @ symmetry) for symmetry in needle_symmetries()]
    pose = rotation, translation, true_rotation, true_translation, points
    rows = [("rotation", "deg", angles[0]), ("rotation, tip and tail exchangeable", "deg", np.min(angles, axis=0)),
            ("translation", "mm", translation_error(translation, true_translation)), ("MSSD", "mm", mssd(*pose)),
            ("MSSD, tip and tail exchangeable", "mm", mssd(*pose, needle_symmetries()))]
    return [(name, unit, float(np.median(values)), float(np.mean(values))) for name, unit, values in rows]
