"""Reads exported folders with numpy, Python's own csv and ffmpeg, and compares them with the expected contents.
The messages of a bag are in EXPECTED/messages.json, from dump_mcap.cjs.
python3 read_exports.py FORMAT FOLDER EXPECTED"""

import csv
import json
import pathlib
import re
import subprocess
import sys

import numpy as np


PIXELS = {"gray": (b"\x08\0", "u1", ()), "rgb24": (b"\x08\2", "u1", (3,)), "gray16le": (b"\x10\0", "<u2", ())}


def pngs(files, pixels="gray"):
    """The PNGs of 64 x 48 pixels, by stamp, decoded by ffmpeg."""
    depth_and_color, kind, channels = PIXELS[pixels]
    assert all(data[16:26] == b"\0\0\0\x40\0\0\0\x30" + depth_and_color for data in files.values())
    decode = ["ffmpeg", "-v", "error", "-f", "image2pipe", "-c:v", "png", "-i", "-", "-f", "rawvideo",
              "-vsync", "passthrough", "-pix_fmt", pixels, "-"]
    decoded = subprocess.run(decode, check=True, capture_output=True, input=b"".join(files.values())).stdout
    return dict(zip(files, np.frombuffer(decoded, kind).reshape(len(files), 48, 64, *channels)))


def table(file, delimiter=","):
    """Rows of a text file, without comment lines."""
    with open(file, newline="") as lines:
        return [row for row in csv.reader(lines, delimiter=delimiter) if not row[0].startswith("#")]


def rotation(x, y, z, w):
    n = x * x + y * y + z * z + w * w
    assert abs(n - 1) < 1e-14
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


class Expected:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.stamps = self.stamps_of("cam0")
        self.has_rig = (self.folder / "X_rgb0.csv").exists()
        self.imu = self.rows("imu")

    def poses(self, name):
        """stamp: (position, rotation)"""
        rows = table(self.folder / f"{name}.csv")
        return {r[0]: (np.array(r[1:4], float), np.array(r[4:], float).reshape(3, 3)) for r in rows}

    def rows(self, name):
        return [[row[0], *map(float, row[1:])] for row in table(self.folder / f"{name}.csv")]

    def stamps_of(self, name):
        return list(dict.fromkeys(row[0] for row in table(self.folder / f"{name}.csv")))

    def image(self, stamp, name="cam0", pixels="gray"):
        _, kind, channels = PIXELS[pixels]
        return np.fromfile(self.folder / f"{name}_{stamp}", kind).reshape(48, 64, *channels)

    def check_rig_images(self, images, name, pixels="gray", stamps=None):
        """images: by stamp"""
        assert list(images) == (stamps or self.stamps_of(name))
        assert all(np.array_equal(image, self.image(t, name, pixels)) for t, image in images.items())

    def pose(self, name):
        """The matrix of a pose without a time."""
        [(p, R)] = self.poses(name).values()
        return np.vstack([np.column_stack([R, p]), [0, 0, 0, 1]])

    def check_images(self, images):
        """images: by stamp"""
        self.check_rig_images(images, "cam0", stamps=self.stamps)

    def check_imu(self, rows):
        assert [row[0] for row in rows] == [row[0] for row in self.imu]
        for row, values in zip(rows, self.imu):
            assert np.allclose(np.array(row[1:], float), values[1:], rtol=1e-12, atol=1e-12)

    def check_poses(self, found, name, stamps=None):
        """found: stamps with position and quaternion x, y, z, w; stamps: expected ones, if not the file's"""
        poses = self.poses(name)
        assert [t for t, _ in found] == (stamps or list(poses))
        for (_, numbers), (p, R) in zip(found, poses.values()):
            x = list(map(float, numbers))
            assert np.array_equal(x[:3], p)
            assert np.abs(rotation(*x[3:]) - R).max() < 1e-14  # a quaternion's rounding

    def check_tum(self, file, name):
        self.check_poses([(row[0].replace(".", ""), row[1:]) for row in table(file, " ")], name)


def euroc(folder, expected):
    cam0, imu0 = folder / "mav0/cam0", folder / "mav0/imu0"
    assert table(cam0 / "data.csv") == [[t, f"{t}.png"] for t in expected.stamps]
    assert (folder / "times.txt").read_text().split() == expected.stamps
    images = sorted((cam0 / "data").iterdir())
    expected.check_images(pngs({file.stem: file.read_bytes() for file in images}))
    expected.check_imu(table(imu0 / "data.csv"))
    truth = table(folder / "mav0/state_groundtruth_estimate0/data.csv")
    assert all(len(row) == 17 for row in truth)
    expected.check_poses([(row[0], row[1:4] + row[5:8] + row[4:5]) for row in truth], "motion")
    if expected.has_rig and not (folder / "settings.yaml").exists():
        euroc_rig(folder, expected)


def euroc_rig(folder, expected):
    """An additional gray eye and an additional IMU with their mounting."""
    cam1, imu1, stamps = folder / "mav0/cam1", folder / "mav0/imu1", expected.stamps_of("right_eye")
    assert table(cam1 / "data.csv") == [[t, f"{t}.png"] for t in stamps]
    expected.check_rig_images(pngs({t: (cam1 / f"data/{t}.png").read_bytes() for t in stamps}), "right_eye")
    both = [t for t in expected.stamps if t in stamps]
    assert (folder / "times_stereo.txt").read_text().split() == both and len(both) == 7
    assert [[row[0], *map(float, row[1:])] for row in table(imu1 / "data.csv")] == expected.rows("chest")
    X_GC = np.linalg.inv(expected.pose("X_CG"))
    for sensor, name, words in ((cam1, "right_eye", "equidistant"), (imu1, "chest", "rate_hz: 100")):
        text = (sensor / "sensor.yaml").read_text()
        X_GS = np.fromstring(re.search(r"data: \[([^]]*)\]", text)[1], sep=",").reshape(4, 4)
        assert words in text and np.abs(X_GS - X_GC @ expected.pose(f"X_{name}")).max() < 1e-12


def orbslam3(folder, expected):
    first, last = int(expected.imu[0][0]), int(expected.imu[-1][0])
    every, expected.stamps = expected.stamps, [t for t in expected.stamps if first < int(t) < last]
    assert 3 < len(expected.stamps) < len(every)  # images without readings on both sides are left out
    euroc(folder, expected)
    expected.check_tum(folder / "groundtruth.tum", "truth")


def openvins(folder, expected):
    euroc(folder, expected)
    expected.check_tum(folder / "groundtruth.tum", "truth")
    bag(expected, "/cam0/image_raw", "/cam0/camera_info", "/imu0")


def mcap(folder, expected):
    messages = bag(expected, "/camera/image/compressed", "/camera/camera_info", "/imu")
    true = {f"ground_truth/{n}": n.replace("camera", "truth") for n in ("camera", "waist", "left_foot", "right_foot")}
    for frame, file in true.items():
        expected.check_poses(transforms(messages["/ground_truth/tf"], "world", frame), file)
    assert len(transforms(messages["/ground_truth/tf"], "world")) == sum(len(expected.poses(f)) for f in true.values())
    check_tree(messages, {"imu": "M_imu0", "cam0_optical_frame": "M_cam0"}, expected)
    assert [m["data"] for m in messages["/robot_description"]] == ["<robot/>"]
    # The test's robot: the first joint moves the thigh along x, the second one the shin along y.
    assert [[t, *p[:3]] for t, p in transforms(messages["/tf"], "waist")] == [
        [t, *p] for t, hip, knee in expected.rows("links") for p in ([hip, 0, 0], [0, knee, 0])]
    for topic, file in (("/ground_truth/path", "truth"), ("/plan/path", "plan"), ("/slam/path", "slam")):
        first, last = messages[topic]
        assert len(first["poses"]) == 1
        expected.check_poses([(stamp(m), pose_of(m["pose"])) for m in last["poses"]], file)
    fields = [[f["name"], f["datatype"]] for f in messages["/slam/map"][0]["fields"]]
    assert fields == [["x", 7], ["y", 7], ["z", 7], ["id", 6]]
    points = [[str(int(stamp(m)) - 10**18), p[3], *p[:3]] for m in messages["/slam/map"] for p in m["points"]]
    assert points == expected.rows("map")
    joints = messages["/joint_states"]
    assert [[stamp(m), *m["position"]] for m in joints] == expected.rows("joints")
    assert all([m["name"], m["velocity"], m["effort"]] == [["hip", "knee"], [], []] for m in joints)
    for foot in ("left", "right"):
        wrenches = messages[f"/{foot}_foot/wrench"]
        assert all(m["header"]["frame_id"] == f"{foot}_foot" for m in wrenches)
        assert [[stamp(m), *xyz(m["wrench"]["force"]), *xyz(m["wrench"]["torque"])]
                for m in wrenches] == expected.rows(f"{foot}_wrench")
    if expected.has_rig:
        mcap_rig(messages, expected)


class Tree:
    """The frames of /tf_static and of the newest /tf, each by its parent and its pose there."""

    def __init__(self, *topics):
        self.parents = {}
        for transform in (t for messages in topics for m in messages for t in m["transforms"]):
            parent, child = transform["header"]["frame_id"], transform["child_frame_id"]
            assert self.parents.get(child, (parent,))[0] == parent, f"{child} has two parents"
            position, quaternion = np.split(np.array(pose_of(transform["transform"])), [3])
            self.parents[child] = parent, np.vstack([np.column_stack([rotation(*quaternion), position]), [0, 0, 0, 1]])

    def roots(self):
        return {parent for parent, _ in self.parents.values()} - set(self.parents)

    def pose(self, frame):
        """In the root."""
        if frame not in self.parents:
            return np.eye(4)
        parent, X = self.parents[frame]
        return self.pose(parent) @ X


def check_tree(messages, sensors, expected):
    """sensors: the frames of sensors, with their poses in the links that carry them: the thigh, or the shin of a camera."""
    tree = Tree(messages["/tf_static"], messages["/tf"])
    assert tree.roots() == {"base_link"} and not any("truth" in frame for frame in tree.parents)
    hip, knee = expected.rows("links")[-1][1:]
    for frame, name in sensors.items():
        X = tree.pose(frame) @ np.linalg.inv(expected.pose(name))
        link = [0, knee, 0] if "optical" in frame else [hip, 0, 0]
        assert np.abs(X - np.vstack([np.column_stack([np.eye(3), link]), [0, 0, 0, 1]])).max() < 1e-12, frame
    assert Tree(messages["/tf_static"], messages["/tf"], messages["/ground_truth/tf"],
                messages["/ground_truth/tf_static"]).roots() == {"world"}


def mcap_rig(messages, expected):
    frames = {"right_eye": "right_eye_optical_frame", "rgb0": "rgb0_optical_frame", "depth0": "rgb0_optical_frame",
              "lidar0": "lidar0_frame", "chest": "chest_frame"}

    def of(name, topic):
        found = messages[f"/rig/{name}/{topic}"]
        assert [stamp(m) for m in found] == expected.stamps_of(name)
        assert all(m["header"]["frame_id"] == frames[name] for m in found)
        return found

    for name, pixels in (("right_eye", "gray"), ("rgb0", "rgb24")):
        coded = {stamp(m): bytes.fromhex(m["data"]) for m in of(name, "image/compressed")}
        expected.check_rig_images(pngs(coded, pixels), name, pixels)
    depths = of("depth0", "image_raw")
    assert all([m["encoding"], m["step"]] == ["16UC1", 128] for m in depths)
    expected.check_rig_images({stamp(m): np.frombuffer(bytes.fromhex(m["data"]), "<u2").reshape(48, 64) for m in depths},
                              "depth0", "gray16le")
    for info in of("right_eye", "camera_info"):
        assert info["distortion_model"] == "equidistant" and abs(info["p"][3] + 0.06 * info["k"][0]) < 1e-12
    for info in of("rgb0", "camera_info"):
        assert info["distortion_model"] == "plumb_bob" and info["p"] == [30, 0, 31.5, 0, 0, 30, 23.5, 0, 0, 0, 1, 0]
    assert all(info["k"] == [30, 0, 31.5, 0, 30, 23.5, 0, 0, 1] for info in of("depth0", "camera_info"))
    sweeps = of("lidar0", "points")
    assert all([f["name"] for f in m["fields"]] == ["x", "y", "z", "intensity", "t", "ring"] for m in sweeps)
    points = [[stamp(m), *map(float, np.float32(p[:5]))] for m in sweeps for p in m["points"]]
    for *point, _, _, ring in (p for m in sweeps for p in m["points"]):
        row = 64 * (np.arctan2(point[2], np.hypot(*point[:2])) + 1.5) / 3  # elevations -1.5 to 1.5 rad
        assert ring == int(np.clip(row, 0, 63)), point
    assert points == [[t, *map(float, np.float32(p))] for t, *p in expected.rows("lidar0")]
    assert [[stamp(m), *xyz(m["angular_velocity"]), *xyz(m["linear_acceleration"])]
            for m in of("chest", "imu")] == expected.rows("chest")
    check_tree(messages, {frames[n]: f"M_{n}" for n in ("right_eye", "rgb0", "lidar0", "chest")}, expected)


def stamp(message):
    t = message["header"]["stamp"]
    return f'{t["sec"]}{t["nanosec"]:09}'


def xyz(v):
    return [v["x"], v["y"], v["z"]]


def pose_of(pose):
    """position and quaternion x, y, z, w of a Pose or a Transform"""
    p, q = (pose["position"], pose["orientation"]) if "position" in pose else (pose["translation"], pose["rotation"])
    return [*xyz(p), *xyz(q), q["w"]]


def transforms(messages, parent, child=None):
    """Stamps and poses of a frame, or of all, in its parent frame."""
    return [(stamp(t), pose_of(t["transform"])) for m in messages for t in m["transforms"]
            if t["header"]["frame_id"] == parent and child in (None, t["child_frame_id"])]


def bag(expected, image_topic, info_topic, imu_topic):
    messages = json.loads((expected.folder / "messages.json").read_text())
    for topic, file in (("/ground_truth/pose", "truth"), ("/plan/pose", "plan")):
        expected.check_poses([(stamp(m), pose_of(m["pose"])) for m in messages[topic]], file)
    expected.check_poses([(stamp(m), pose_of(m["pose"]["pose"])) for m in messages["/slam/pose"]], "slam")
    for m in messages["/slam/pose"]:
        diagonal = np.array(m["pose"]["covariance"]).reshape(6, 6).diagonal()
        assert np.abs(diagonal - [1e-6, 4e-6, 9e-6, 2e-6, 2e-6, 2e-6]).max() < 1e-18
    images, coded = {}, {}
    for info, m in zip(messages[info_topic], messages[image_topic]):
        k = info["k"]
        assert stamp(info) == stamp(m) and [info["width"], info["height"], k[2], k[5]] == [64, 48, 31.4, 25.4]
        assert info["distortion_model"] == "equidistant" and len(info["d"]) == 4
        data = bytes.fromhex(m["data"])
        if "format" in m:
            assert m["format"] == "png"
            coded[stamp(m)] = data
        else:
            assert [m["encoding"], m["step"]] == ["mono8", m["width"]]
            images[stamp(m)] = np.frombuffer(data, np.uint8).reshape(48, 64)
    images |= pngs(coded) if coded else {}
    assert len(messages[info_topic]) == len(messages[image_topic])
    expected.check_images(images)
    expected.check_imu([[stamp(m), *xyz(m["angular_velocity"]), *xyz(m["linear_acceleration"])] for m in messages[imu_topic]])
    for m in messages[imu_topic]:
        assert m["orientation_covariance"][0] == -1
        assert abs(m["angular_velocity_covariance"][4] - 1e-4) < 1e-18  # (0.01 rad/s)²
    return messages


def tum(folder, expected):
    rows = table(folder / "rgb.txt", " ")
    assert len((folder / "rgb.txt").read_text().splitlines()) == len(rows) + 3  # readers skip three lines
    if expected.has_rig:
        return tum_rig(folder, expected, rows)
    images = pngs({row[0].replace(".", ""): (folder / row[1]).read_bytes() for row in rows})
    expected.check_rig_images(images, "straight")  # without distortion
    expected.check_tum(folder / "groundtruth.txt", "truth")
    expected.check_tum(folder / "plan.txt", "plan")


def tum_rig(folder, expected, images):
    """Color, depth and their pairs."""
    depths = table(folder / "depth.txt", " ")
    for rows, name, pixels in ((images, "rgb0", "rgb24"), (depths, "depth0", "gray16le")):
        coded = {row[0].replace(".", ""): (folder / row[1]).read_bytes() for row in rows}
        expected.check_rig_images(pngs(coded, pixels), name, pixels)
    assert table(folder / "associations.txt", " ") == [a + b for a, b in zip(images, depths)]
    settings = dict(line.split(": ", 1) for line in (folder / "settings.yaml").read_text().splitlines() if ": " in line)
    for key, value in (("RGBD.DepthMapFactor", 1000), ("Stereo.b", 0.05), ("Camera1.fx", 30), ("Camera.RGB", 0)):
        assert float(settings[key]) == value, key  # OpenCV reads BGR
    truth, (p, R) = table(folder / "groundtruth.txt", " "), list(expected.poses("truth").values())[-1]
    assert np.abs(np.array(truth[-1][1:4], float) - p - R @ expected.pose("X_rgb0")[:3, 3]).max() < 1e-12


if __name__ == "__main__":
    format, folder, expected = sys.argv[1:]
    globals()[format](pathlib.Path(folder), Expected(expected))
