"""Reads exported folders with numpy, Python's own csv and ffmpeg, and compares them with the expected contents.
python3 read_exports.py FORMAT FOLDER EXPECTED"""

import csv
import pathlib
import re
import subprocess
import sys

import numpy as np


def png(file):
    """An 8-bit grey PNG of 64 x 48 pixels, decoded by ffmpeg."""
    assert file.read_bytes()[16:26] == b"\0\0\0\x40\0\0\0\x30\x08\0", file
    decode = ["ffmpeg", "-v", "error", "-i", file, "-f", "rawvideo", "-pix_fmt", "gray", "-"]
    return np.frombuffer(subprocess.run(decode, check=True, capture_output=True).stdout, np.uint8).reshape(48, 64)


def table(file, delimiter=","):
    """Rows of a text file; lines of comment left out."""
    with open(file, newline="") as lines:
        return [row for row in csv.reader(lines, delimiter=delimiter) if not row[0].startswith("#")]


def rotation(x, y, z, w):
    n = x * x + y * y + z * z + w * w
    assert abs(n - 1) < 1e-14
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def pinhole_focal(calibration):
    text = calibration.read_text()
    numbers = lambda key: [float(x) for x in re.search(key + r": \[(.*?)\]", text)[1].split(",")]
    assert re.search("distortion_model: (.*)", text)[1] in ("radtan", "radial-tangential")
    assert numbers("distortion_coeff[a-z]*") == [0, 0, 0, 0]
    fu, fv, u0, v0 = numbers("intrinsics")
    assert (fu, u0, v0) == (fv, 31.4, 25.4)
    return fu


class Expected:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.pinhole = (self.folder / "undistorted").exists()
        self.stamps = [row[0] for row in table(self.folder / "images.csv")]
        self.truth = self.poses("truth.csv")
        self.imu = [(row[0], np.array(row[1:], float)) for row in table(self.folder / "imu.csv")]

    def poses(self, name):
        """stamp: (position, rotation)"""
        rows = table(self.folder / name)
        return {r[0]: (np.array(r[1:4], float), np.array(r[4:], float).reshape(3, 3)) for r in rows}

    def image(self, stamp):
        return np.fromfile(self.folder / f"{stamp}.grey", np.uint8).reshape(48, 64)

    def check_images(self, folder, calibration):
        """calibration: the YAML file with the lens of the images."""
        assert sorted(f.name for f in folder.iterdir()) == [f"{t}.png" for t in self.stamps]
        if self.pinhole:
            f = pinhole_focal(calibration)
            return check_undistorted(self, [folder / f"{t}.png" for t in self.stamps], f)
        for t in self.stamps:
            assert np.array_equal(png(folder / f"{t}.png"), self.image(t)), t

    def check_imu(self, rows):
        assert [row[0] for row in rows] == [t for t, _ in self.imu]
        for row, (_, values) in zip(rows, self.imu):
            assert np.allclose(np.array(row[1:], float), values, rtol=1e-12, atol=1e-12)

    def check_tum(self, file, poses):
        rows = table(file, " ")
        assert len(rows) == len(poses)
        for row, (stamp, (p, R)) in zip(rows, poses.items()):
            assert row[0].replace(".", "") == stamp, row
            assert np.array_equal(np.array(row[1:4], float), p)
            assert np.abs(rotation(*map(float, row[4:])) - R).max() < 1e-14  # a quaternion's rounding


def euroc(folder, expected):
    cam0, imu0 = folder / "mav0/cam0", folder / "mav0/imu0"
    assert table(cam0 / "data.csv") == [[t, f"{t}.png"] for t in expected.stamps]
    assert (folder / "times.txt").read_text().split() == expected.stamps
    expected.check_images(cam0 / "data", cam0 / "sensor.yaml")
    expected.check_imu(table(imu0 / "data.csv"))
    truth = table(folder / "mav0/state_groundtruth_estimate0/data.csv")
    motion = expected.poses("motion.csv")
    assert [row[0] for row in truth] == list(motion) and all(len(row) == 17 for row in truth)
    for row in truth:
        p, R = motion[row[0]]
        x = list(map(float, row))
        assert np.array_equal(x[1:4], p) and np.abs(rotation(*x[5:8], x[4]) - R).max() < 1e-14


def orbslam3(folder, expected):
    first, last = int(expected.imu[0][0]), int(expected.imu[-1][0])
    every, expected.stamps = expected.stamps, [t for t in expected.stamps if first < int(t) < last]
    assert 3 < len(expected.stamps) < len(every)  # images without readings on both sides are left out
    euroc(folder, expected)
    if expected.pinhole:
        assert focal(folder / "settings.yaml") == pinhole_focal(folder / "mav0/cam0/sensor.yaml")
    expected.check_tum(folder / "groundtruth.tum", expected.truth)


def openvins(folder, expected):
    euroc(folder, expected)
    expected.check_tum(folder / "groundtruth.tum", expected.truth)


def undistorted(expected, stamp, f):
    """The view of a pinhole with this focal length, computed independently of the exporter."""
    v, u = np.mgrid[0:48, 0:64].astype(float)
    a, b = 39.4 * (u - 31.4) / f, 39.0 * (v - 25.4) / f
    root = np.sqrt(1 + 2 * 7.37e-6 * 25 * (a * a + b * b))
    x, y = 31.4 + a / root, 25.4 + b / root
    assert x.min() >= 0 and y.min() >= 0 and x.max() <= 63 and y.max() <= 47
    i, j = np.minimum(x.astype(int), 62), np.minimum(y.astype(int), 46)
    s, t = x - i, y - j
    image = expected.image(stamp).astype(float)
    return ((1 - t) * ((1 - s) * image[j, i] + s * image[j, i + 1])
            + t * ((1 - s) * image[j + 1, i] + s * image[j + 1, i + 1]))


def check_undistorted(expected, files, f):
    assert len(files) == len(expected.stamps)
    for file, stamp in zip(files, expected.stamps):
        # half a grey level is the rounding
        assert np.abs(png(file) - undistorted(expected, stamp, f)).max() < 0.5 + 1e-9, file


def focal(settings):
    lines = dict(line.split(": ", 1) for line in settings.read_text().splitlines() if ": " in line)
    assert lines["Camera.type"] == '"PinHole"' and lines["Camera1.fx"] == lines["Camera1.fy"]
    return float(lines["Camera1.fx"])


def tum(folder, expected):
    rows = table(folder / "rgb.txt", " ")
    assert len((folder / "rgb.txt").read_text().splitlines()) == len(rows) + 3  # readers skip three lines
    assert [row[0].replace(".", "") for row in rows] == expected.stamps
    check_undistorted(expected, [folder / row[1] for row in rows], focal(folder / "settings.yaml"))
    expected.check_tum(folder / "groundtruth.txt", expected.truth)
    expected.check_tum(folder / "plan.txt", expected.poses("plan.csv"))


if __name__ == "__main__":
    format, folder, what = sys.argv[1:]
    globals()[format](pathlib.Path(folder), Expected(what))
