"""Test of fire3dv.read_calibration: camera files of ROS, OpenCV and Kalibr, alone and in pairs, against cameras worked out by hand;
files with faults are refused with file and field."""
import math
import os
import tempfile

import fire3dv

ROS = """# of camera_calibration
image_width: 640
image_height: 480
camera_name: {name}
camera_matrix:
  rows: 3
  cols: 3
  data: [500.0, 0.0, 320.5,
         0.0, 510.0, 241.25, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.2, 0.05, 0.001, -0.002, 0.01]
rectification_matrix:
  rows: 3
  cols: 3
  data: {rotation}
projection_matrix:
  rows: 3
  cols: 4
  data: [480.0, 0.0, 320.0, {tx}, 0.0, 480.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]
"""
ECHO = """---
header:
  stamp:
    sec: 3
  frame_id: 'left'
height: 480
width: 640
distortion_model: equidistant
d:
- 0.1
- 0.0
- 0.02
- -0.001
k: [500.0, 0.0, 320.5, 0.0, 510.0, 241.25, 0.0, 0.0, 1.0]
"""
KALIBR = """cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.3, 0.1, 0.0002, -1.0e-4]
  distortion_model: radtan
  intrinsics: [458.5, 457.25, 367.25, 248.5]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.0, -1.0, 0.0, -0.11]
  - [1.0, 0.0, 0.0, 0.02]
  - [0.0, 0.0, 1.0, 0.003]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [0.01, 0.02, 0.03, 0.04]
  distortion_model: equidistant
  intrinsics: [450.0, 451.0, 360.0, 240.0]
  resolution: [752, 480]
"""
OPENCV = """%YAML:1.0
---
calibration_time: "Mon 30 Nov 2026"
image_width: 640
image_height: 480
flags: 0
fisheye_model: {fisheye}
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 500., 0., 320.5, 0., 510.,
       241.25, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: {count}
   cols: 1
   dt: d
   data: [ -2.0e-01, 5.0e-02, 1.0e-03, -2.0e-03{more} ]
"""
MATRIX = '<{0} type_id="opencv-matrix"><rows>{1}</rows><cols>{2}</cols><dt>d</dt><data>\n {3}</data></{0}>\n'
XML = '<?xml version="1.0"?>\n<opencv_storage>\n' + MATRIX.format("M1", 3, 3, "500. 0. 320.5 0. 510. 241.25 0. 0. 1.") + \
    MATRIX.format("D1", 1, 5, "-0.2 0.05 0.001 -0.002 0.01") + MATRIX.format("M2", 3, 3, "501. 0. 321. 0. 511. 242. 0. 0. 1.") + \
    MATRIX.format("D2", 1, 5, "0 0 0 0 0") + "</opencv_storage>\n"
EXTRINSICS = """%YAML:1.0
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0., 0., 1., 0., 1., 0., -1., 0., 0. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.005, 0.001, 0.002 ]
"""


def write(name, text):
    path = os.path.join(folder, name)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def refused(wanted, text, *more, name="bad.yaml", **options):
    path = write(name, text)
    try:
        fire3dv.read_calibration(path, *more, **options)
    except fire3dv.ArgumentError as error:
        assert wanted in str(error) and (path in str(error) or more), error
        return
    raise AssertionError(f"nothing was raised, expected: {wanted}")


def has(camera, **wanted):
    for name, value in wanted.items():
        found = getattr(camera, name)
        assert found == value, (name, found, value)


def close(found, wanted):
    assert len(found) == len(wanted) and all(math.isclose(a, b, abs_tol=1e-9) for a, b in zip(found, wanted)), (found, wanted)


def seen_by_first(camera, point):
    """A point of the camera in OpenCV's axes, as the first camera has it in the same."""
    local = (point[0], -point[1], -point[2], 1)
    rows = [camera.first_from_camera[i:i + 4] for i in (0, 4, 8)]
    x, y, z = (sum(a * b for a, b in zip(row, local)) for row in rows)
    return x, -y, -z


def matrix_of_plain_camera(camera):
    has(camera, width=640, height=480, fx=500, fy=510, cx=320.5, cy=241.25)


with tempfile.TemporaryDirectory() as folder:
    identity = "[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]"
    left = write("left.yaml", ROS.format(name="left", rotation=identity, tx=0.0))
    [camera] = fire3dv.read_calibration(left)
    matrix_of_plain_camera(camera)
    has(camera, name="left", lens="plumb_bob", lens_coefficients=(-0.2, 0.05, 0.001, -0.002, 0.01))
    close(camera.first_from_camera, (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0))
    # Half the size: the same angles.
    half = camera.request(320, 240)
    assert (half["width"], half["height"], half["fx"], half["fy"], half["cx"], half["cy"]) == (320, 240, 250, 255, 160, 120.375), half
    assert camera.request()["fx"] == 500 and half["lens"] == "plumb_bob"

    # A right camera that is 6 mm to the right; its rectified axes are turned about Y by a quarter.
    right = write("right.yaml", ROS.format(name="right", rotation="[0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0]", tx=-480 * 0.006))
    cameras = fire3dv.read_calibration(left, right)
    assert [camera.name for camera in cameras] == ["left", "right"]
    close(seen_by_first(cameras[1], (0, 0, 0)), (0.006, 0, 0))
    close(seen_by_first(cameras[1], (0, 0, 1)), (1.006, 0, 0))
    close(seen_by_first(cameras[1], (0, 1, 0)), (0.006, 1, 0))

    [camera] = fire3dv.read_calibration(write("echo.yaml", ECHO))
    matrix_of_plain_camera(camera)
    has(camera, name="echo", lens="fisheye", lens_coefficients=(0.1, 0.0, 0.02, -0.001))

    cameras = fire3dv.read_calibration(write("camchain.yaml", KALIBR))
    assert len(cameras) == 2
    has(cameras[0], name="cam0", width=752, height=480, fx=458.5, fy=457.25, cx=367.25, cy=248.5, lens="plumb_bob",
        lens_coefficients=(-0.3, 0.1, 0.0002, -1e-4, 0.0))
    has(cameras[1], name="cam1", lens="fisheye", lens_coefficients=(0.01, 0.02, 0.03, 0.04))
    # p1 = R p0 + t, so that the origin of cam1 is at -R^T t of cam0.
    close(seen_by_first(cameras[1], (-0.11, 0.02, 0.003)), (0, 0, 0))
    close(seen_by_first(cameras[1], (-0.11, 1.02, 0.003)), (1, 0, 0))

    for fisheye, lens, coefficients in ((0, "plumb_bob", (-0.2, 0.05, 0.001, -0.002, 0.0)), (1, "fisheye", (-0.2, 0.05, 0.001, -0.002))):
        path = write("out_camera_data.yml", OPENCV.format(fisheye=fisheye, count=4, more=""))
        [camera] = fire3dv.read_calibration(path)
        matrix_of_plain_camera(camera)
        has(camera, name="out_camera_data", lens=lens, lens_coefficients=coefficients)
    [camera] = fire3dv.read_calibration(path, fisheye=False)
    has(camera, lens="plumb_bob")

    intrinsics, extrinsics = write("intrinsics.xml", XML), write("extrinsics.yml", EXTRINSICS)
    cameras = fire3dv.read_calibration(intrinsics, extrinsics, size=(640, 480))
    matrix_of_plain_camera(cameras[0])
    has(cameras[1], fx=501, fy=511, cx=321, cy=242, lens="none", width=640)
    close(seen_by_first(cameras[1], (-0.005, 0.001, 0.002)), (0, 0, 0))
    close(seen_by_first(cameras[1], (0.995, 0.001, 0.002)), (0, 0, 1))

    # Faults name the file, the field, and what to do.
    refused("has no camera", "a: 1\nb: [1, 2]\n")
    refused("no names with values", "- 1\n- 2\n")
    refused("size=(width, height)", XML, name="bad.xml")
    refused("k4 to k6", OPENCV.format(fisheye=0, count=8, more=", 0., 0.1, 0., 0."))
    refused("has 3 coefficients", ROS.format(name="x", rotation=identity, tx=0).replace("-0.2, 0.05, 0.001, -0.002, 0.01", "1, 2, 3"))
    refused("camera_matrix has 8 numbers", ROS.format(name="x", rotation=identity, tx=0).replace("500.0, 0.0, 320.5,", "500.0, 0.0,"))
    refused("rectification_matrix is no rotation", ROS.format(name="x", rotation=identity.replace("1.0", "2.0"), tx=0))
    refused("a whole number of pixels", ROS.format(name="x", rotation=identity, tx=0).replace("640", "6400000"))
    refused("a finite number", ROS.format(name="x", rotation=identity, tx=0).replace("500.0", ".nan"))
    refused("skew", ROS.format(name="x", rotation=identity, tx=0).replace("500.0, 0.0,", "500.0, 7.0,"))
    refused("not positive", ROS.format(name="x", rotation=identity, tx=0).replace("500.0", "-500.0"))
    refused("is 'thin_prism'", ROS.format(name="x", rotation=identity, tx=0).replace("plumb_bob", "thin_prism"))
    refused("cam1.T_cn_cnm1 is missing", KALIBR.replace("T_cn_cnm1", "T_other"))
    refused("cam0.camera_model is 'omni'", KALIBR.replace("pinhole", "omni", 1))
    refused("in one file", KALIBR, left)
    refused("declarations", '<?xml version="1.0"?>\n<!DOCTYPE a [<!ENTITY b "c">]>\n<opencv_storage></opencv_storage>', name="bad.xml")
    refused("opencv_storage", "<a></a>", name="bad.xml")
    refused("line 2", "a: 1\n   b: 2\n")
    refused("does not end", "camera_matrix: [1, 2\n")
    refused("more than 16", "a: " + "[" * 60 + "]" * 60)
    refused("more than 16", "\n".join(" " * i + "a:" for i in range(60)))
    refused("& is not supported", "a: &b 1\n")
    refused("1 MiB", "a: 1\n" * 300000)
    for call in (lambda: fire3dv.read_calibration(os.path.join(folder, "absent.yaml")), fire3dv.read_calibration):
        try:
            call()
        except fire3dv.ArgumentError:
            continue
        raise AssertionError("nothing was raised")
