#!/usr/bin/env python3
"""Compares the scores of gaitslam with numbers that numpy computes from the same files.

score_oracle.py PROGRAM         synthetic trajectories: every alignment, relation and kind of span of `gaitslam score`, and input that
                                cannot be scored: an error with a reason and, if one is at fault, the line
score_oracle.py PROGRAM RESULT  the metrics of a result's score.json that its text files determine
Exits with 1 and lists what differs by more than 1e-9 (relative to 1 or the value, whichever is larger).
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

TOLERANCE = 1e-9
faults, checks = [], 0


def check(name, ours, oracle):
    global checks
    checks += 1
    ours = float(ours) if ours is not None else None
    if ours is None or not abs(ours - oracle) <= TOLERANCE * max(1, abs(oracle)):
        faults.append(f"{name}: program {ours}, oracle {oracle}")


# --- rotations, by quaternions and Rodrigues' formula; the program uses Eigen's matrices ---

def rotation(q):
    x, y, z, w = q / np.linalg.norm(q)
    v = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * v + 2 * v @ v


def quaternion_of(S):
    """The rotation R with the largest trace of R^T S: the top eigenvector of Horn's 4x4 matrix."""
    D = np.array([S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]])
    K = np.block([[S + S.T - np.trace(S) * np.eye(3), D[:, None]], [D[None], np.trace(S)]])
    return np.linalg.eigh(K)[1][:, -1]


def quaternion(axis_angle):
    a = np.linalg.norm(axis_angle)
    return np.append(np.sinc(a / 2 / np.pi) / 2 * np.array(axis_angle), math.cos(a / 2))


def angle(R):
    """Computed from the chord |R - I| = 2 sqrt(2) sin(angle/2), and from the trace beyond a right angle."""
    sine = np.linalg.norm(R - np.eye(3)) / (2 * math.sqrt(2))
    return 2 * math.asin(sine) if sine < 0.7 else math.acos(max(-1, (np.trace(R) - 1) / 2))


def log(R):
    a = angle(R)
    v = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    return v if a < 1e-9 else v * a / math.sin(a)


def pose(row):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = rotation(row[4:8]), row[1:4]
    return X


def yaw(R):
    """The turn about z nearest to R: maximizes the trace of Rz(a)^T R."""
    return math.atan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1])


def turn(X, i, j):
    return angle(X[i, :3, :3].T @ X[j, :3, :3])


# --- alignments ---

def similarity(kind, T, E):
    """scale, R, t; None if not determined."""
    A, B = T[:, :3, 3], E[:, :3, 3]
    a, b = A.mean(0), B.mean(0)
    about = lambda s, R: (s, R, a - s * R @ b)
    if kind == "none":
        return 1, np.eye(3), np.zeros(3)
    if kind == "origin":
        R = T[0, :3, :3] @ E[0, :3, :3].T
        return 1, R, A[0] - R @ B[0]
    spread = np.linalg.svd(B - b, compute_uv=False)
    if kind == "yaw":
        P, Q = (A - a)[:, 0] + 1j * (A - a)[:, 1], (B - b)[:, 0] + 1j * (B - b)[:, 1]
        turn = np.vdot(Q, P)  # sum conj(Q) P
        if abs(turn) < 1e-9:
            return None
        c, s = turn.real / abs(turn), turn.imag / abs(turn)
        return about(1, np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
    if len(A) < 3 or spread[1] < 1e-6 * max(spread[0], 1e-300) or spread[0] < 1e-9:
        return None
    R = rotation(quaternion_of((A - a).T @ (B - b)))
    scale = np.sum((A - a) * ((B - b) @ R.T)) / np.sum((B - b) ** 2)
    return {"se3": about(1, R), "sim3": about(scale, R), "scale": (scale, np.eye(3), np.zeros(3))}[kind]


def apply(S, E):
    s, R, t = S
    out = E.copy()
    out[:, :3, :3] = R @ E[:, :3, :3]
    out[:, :3, 3] = s * E[:, :3, 3] @ R.T + t
    return out


# --- errors ---

def of_difference(D, relation):
    if relation in ("trans_part", "point_distance"):
        return np.linalg.norm(D[:3, 3])
    if relation.startswith("angle"):
        return math.degrees(angle(D[:3, :3])) if relation == "angle_deg" else angle(D[:3, :3])
    return np.linalg.norm(D - np.eye(4)) if relation == "full" else np.linalg.norm(D[:3, :3] - np.eye(3))


def ape(T, E, relation="trans_part"):
    return np.array([of_difference(np.linalg.inv(Q) @ P, relation) for Q, P in zip(T, E)])


def rpe(T, E, pairs, relation="trans_part"):
    if relation == "point_distance":
        gap = lambda X, i, j: np.linalg.norm(X[j, :3, 3] - X[i, :3, 3])
        return np.array([abs(gap(T, i, j) - gap(E, i, j)) for i, j in pairs])
    return np.array([of_difference(np.linalg.inv(np.linalg.inv(T[i]) @ T[j]) @ np.linalg.inv(E[i]) @ E[j], relation)
                     for i, j in pairs])


def walked(X):
    return np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(X[:, :3, 3], axis=0), axis=1))])


def pairs_all(place, delta, tolerance=0.1):
    pairs = []
    for i in range(len(place) - 1):
        off = np.abs(place[i + 1:] - place[i] - delta)
        j = int(np.argmin(off))
        if off[j] <= tolerance * delta:
            pairs.append((i, i + 1 + j))
    return pairs


def pairs_consecutive(place, delta, meters):
    marks, i = [] if meters else [0], 0
    while True:
        later = np.nonzero(place[i + 1:] - place[i] >= delta - (0 if meters else 5e-10))[0]
        if len(later) == 0:
            return list(zip(marks, marks[1:]))
        i = i + 1 + int(later[0])
        marks.append(i)


def turned(X):
    """The turning from pose to pose adds up."""
    return np.cumsum([0] + [turn(X, i, i + 1) for i in range(len(X) - 1)])


def check_statistics(name, row, errors):
    if len(errors) == 0:
        return check(name + ".n", row["n"], 0)
    check(name + ".n", row["n"], len(errors))
    for key, value in (("rmse", math.sqrt(np.mean(errors ** 2))), ("mean", errors.mean()), ("median", np.median(errors)),
                       ("std", errors.std()), ("min", errors.min()), ("max", errors.max()), ("sse", np.sum(errors ** 2)),
                       ("p95", np.percentile(errors, 95)), ("p99", np.percentile(errors, 99))):
        check(f"{name}.{key}", row.get(key), value)


# --- trajectories made up here ---

def tum(path, t, X, unit=1):
    with open(path, "w") as out:
        for stamp, pose_ in zip(t, X):
            text = f"{stamp:.9f}" if unit == 1 else str(round(stamp * 1e9))
            out.write(" ".join([text] + [repr(float(v)) for v in list(pose_[:3, 3]) + list(quaternion_of(pose_[:3, :3]))]) + "\n")


def made_up(kind, n, seed):
    random = np.random.default_rng(seed)
    s = np.linspace(0, 6, n)
    p = {"curve": np.stack([np.cos(s), np.sin(s), 0.3 * np.sin(2 * s)], 1), "plane": np.stack([np.cos(s), np.sin(2 * s), 0 * s], 1),
         "line": np.stack([s, 2 * s, 0.5 * s], 1), "point": np.ones((n, 3))}[kind]
    X = np.tile(np.eye(4), (n, 1, 1))
    for i in range(n):
        X[i, :3, :3] = rotation(quaternion([0.1 * math.sin(s[i]), 0.2 * math.cos(s[i]), 1.05 * s[i]]))  # once around
        X[i, :3, 3] = p[i]
    G, E = rotation(quaternion([0.2, -0.1, 0.4])), X.copy()
    for i in range(n):
        E[i, :3, :3] = G @ X[i, :3, :3] @ rotation(quaternion(0.02 * random.standard_normal(3)))
        E[i, :3, 3] = 1.03 * G @ X[i, :3, 3] + [0.5, 1, -1]
    if kind in ("curve", "plane"):
        E[:, :3, 3] += 0.03 * random.standard_normal((n, 3))
    return X, E


def run(program, *arguments, cwd=None):
    return subprocess.run([program, "score", *arguments], cwd=cwd, capture_output=True, text=True)


def check_score(program):
    folder = pathlib.Path(tempfile.mkdtemp())
    t = np.arange(90) / 30
    for kind in ("curve", "plane", "line", "point"):
        T, E = made_up(kind, len(t), 7)
        a, b = folder / f"{kind}_truth.tum", folder / f"{kind}_estimate.tum"
        tum(a, t, T)
        tum(b, t, E, unit=1e9 if kind == "plane" else 1)  # one of them in nanoseconds
        declared = ["--columns", "t[ns] x y z qx qy qz qw"] if kind == "plane" else []
        relations = ("trans_part", "angle_deg", "angle_rad", "rot_part", "full", "point_distance")
        few = relations if kind == "curve" else relations[:1]
        for alignment in ("none", "origin", "yaw", "se3", "sim3", "scale"):
            S = similarity(alignment, T, E)
            for relation in few:
                ran = run(program, a, b, *declared, "--align", alignment, "-r", relation, "--json")
                name = f"{kind} {alignment} {relation}"
                if S is None or kind == "point":  # a trajectory without motion is an error of its writer
                    check(name + " refused", ran.returncode, 2)
                    check(name + " reason in one line", ran.stderr.count("\n"), 1)
                    continue
                scored = json.loads(ran.stdout)
                check_statistics(name, scored["errors"][0], ape(T, apply(S, E), relation))
                check(name + ".scale", scored["scale"], S[0])
                check(name + ".matched", scored["poses_matched"], len(t))
        if kind == "point":
            continue
        meters, along_truth = walked(E), walked(T)
        frames = np.arange(len(t), dtype=float)
        for options, pairs in ((["-d", "5"], pairs_consecutive(frames, 5, False)), (["-d", "7", "--all-pairs"], pairs_all(frames, 7, 0)),
                               (["-d", "0.5", "-u", "m"], pairs_consecutive(meters, 0.5, True)),
                               (["-d", "0.5", "-u", "m", "--all-pairs"], pairs_all(meters, 0.5)),
                               (["-d", "0.5", "-u", "m", "--pairs-from-reference"], pairs_consecutive(along_truth, 0.5, True)),
                               (["-d", "0.2", "-u", "s"], pairs_consecutive(t, 0.2, False)),
                               (["-d", "0.31", "-u", "s", "--all-pairs"], pairs_all(t, 0.31)),
                               (["-d", "20", "--delta_unit", "d"], pairs_consecutive(turned(E), math.radians(20), False)),
                               (["-d", "0.3", "-u", "r", "--pairs-from-reference"], pairs_consecutive(turned(T), 0.3, False)),
                               (["-d", "25", "-u", "d", "--all-pairs"],  # to 10 %
                                [(i, j) for i in range(len(E)) for j in range(i + 1, len(E))
                                 if abs(turn(E, i, j) - math.radians(25)) <= 0.1 * math.radians(25)])):
            for relation in few:
                scored = json.loads(run(program, a, b, *declared, *options, "-r", relation, "--json").stdout)
                check_statistics(f"{kind} rpe {options} {relation}", scored["errors"][0], rpe(T, E, pairs, relation))
    out = run(program, folder / "curve_truth.tum", folder / "curve_estimate.tum").stdout
    check("every alignment is shown", sum(out.count("APE " + a) for a in ("none", "origin", "yaw", "se3", "sim3", "scale")), 7)


def tum_line(t, x, y):
    return f"{t:.9f} {x} {y} 1 0 0 0 1\n"


def curve(row, count=300):
    """Ten seconds at 30 Hz: row(i, t, y = sin t)."""
    return "".join(row(i, i / 30, math.sin(i / 30)) for i in range(count))


FILES = {  # each as if its path were x = t, y = sin t
    "truth.tum": curve(lambda i, t, y: tum_line(t, t, y)),
    "frames.tum": curve(lambda i, t, y: f"{i} {t} {y} 1 0 0 0 1\n"),
    "poses.csv": curve(lambda i, t, y: f"{i},{t},{y},1,1,0,0,0\n"),
    "mm.tum": curve(lambda i, t, y: tum_line(t, 1000 * t, 1000 * y)),
    "ahead.tum": curve(lambda i, t, y: tum_line(0.4 + t, t, y)),
    "gps.tum": curve(lambda i, t, y: tum_line(-3 + t, t, y)),
    "turned.tum": curve(lambda i, t, y: f"{t} {t} {y} 1 0 0.6 0 0.8\n"),
    "helix.tum": curve(lambda i, t, y: f"{t} {math.cos(t)} {y} {0.3 * t} 0 0 0 1\n"),
    "mirrored.tum": curve(lambda i, t, y: f"{t} {math.cos(t)} {-y} {0.3 * t} 0 0 0 1\n"),
    "flat.tum": curve(lambda i, t, y: tum_line(t, t, -y)),
    "degrees.tum": curve(lambda i, t, y: tum_line(t, math.degrees(t), math.degrees(y))),
    "poses.txt": curve(lambda i, t, y: f"1 0 0 {t} 0 1 0 {y} 0 0 1 1\n"),
    "half.txt": curve(lambda i, t, y: f"1 0 0 {2 * t} 0 1 0 {y} 0 0 1 1\n", 150),
    "fewer.txt": curve(lambda i, t, y: "" if i < 10 else f"1 0 0 {2 * t} 0 1 0 {y} 0 0 1 1\n"),
    "once_a_second.tum": curve(lambda i, t, y: f"{i} {i} {math.sin(i)} 1 0 0 0 1\n", 10),
    "us.csv": "time[us],x,y,z,qw,qx,qy,qz\n" + curve(lambda i, t, y: f"{1e6 * t:.0f},{t},{y},1,1,0,0,0\n"),
    "ms.tum": curve(lambda i, t, y: tum_line(1000 * t, t, y)),
    "minutes.tum": curve(lambda i, t, y: tum_line(t / 60, t, y)),
    # Stamps of exports start at 1e9 s; a program that needs time to initialize has no poses for the first seconds.
    "late.tum": curve(lambda i, t, y: "" if i < 141 else tum_line(1e9 + t, t, 0)),
    "shifted.tum": curve(lambda i, t, y: tum_line(77.25 + t, t, 0)),
    "later.tum": curve(lambda i, t, y: tum_line((298 + i) / 30, t, 0)),
    "still.tum": curve(lambda i, t, y: tum_line(t, 2, 1)),
    "short.tum": tum_line(0, 0, 0) + tum_line(1 / 30, 0.1, 0) + tum_line(2 / 30, 0.2, 0),
    "gap.tum": curve(lambda i, t, y: tum_line(t, t, y) if i < 100 or i > 200 else ""),
    "straight.tum": curve(lambda i, t, y: tum_line(t, t, 0)),
    "two.tum": curve(lambda i, t, y: tum_line(t, t, 0) if i < 60 or i >= 240 else ""),
    "first.tum": curve(lambda i, t, y: tum_line(t, t, 0) if i < 60 else ""),
    "stands.tum": curve(lambda i, t, y: tum_line(t, 1e-4 * y, 1e-4 * math.cos(i))),
    "noisy.tum": curve(lambda i, t, y: tum_line(t, 0.1 * math.sin(i * i), 0.1 * math.cos(7 * i))),
    "positions.csv": "#timestamp [s],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m]\n" + curve(lambda i, t, y: f"{t:.9f},{t},{y},1\n"),
    "named.csv": "t[s],tx,ty,tz,qx,qy,qz,qw," + ",".join(f"P{b}{e}" for b in "tr" for e in (11, 12, 13, 22, 23, 33)) + "\n"
    + curve(lambda i, t, y: f"{t:.9f},{t},{y + 0.2 * (i % 2)},1,0,0,0,1,.01,0,0,.01,0,.01,1,0,0,1,0,1\n"),
    "sure.tum": curve(lambda i, t, y: f"{t:.9f} {2 * t} 0 1 0 0 0 1 1 0 0 1 0 1 1e-307 0 0 1e-307 0 1e-307\n"),
}
REFUSED = [
    ("truth.tum frames.tum", "frames.tum: its 300 poses last 299.000 s, the 300 of truth.tum last 9.967 s: the stamps of one are in another unit"),
    ("frames.tum truth.tum", "frames.tum: its 300 poses last 299.000 s"),
    ("truth.tum poses.txt", "poses.txt: its stamps are frame numbers, but truth.tum has times; write times.txt"),
    ("truth.tum poses.csv", "poses.csv:1: no header names the comma-separated columns (decimal commas need semicolons or tabs); the "
                            "first row has 8 columns: 0,0.0,0.0,1,1,0,0,0; expected TUM"),
    ("truth.tum ms.tum", "ms.tum: its 300 poses last 9966.667 s, the 300 of truth.tum"),
    *((f"truth.tum minutes.tum{more}", "truth.tum: its 300 poses last 9.967 s, the 300 of minutes.tum last 0.166 s: the stamps of one are")
      for more in ("", " --interpolate")),
    *((f"truth.tum truth.tum --align none --t-offset {value}", "--t-offset ") for value in ("inf", "nan", "1e10", "-1e300")),
    ("truth.tum truth.tum --t-max-diff nan", "--t-max-diff"),
    *((f"truth.tum truth.tum -d 1 -u m --all-pairs --delta-tol {value}", "--delta-tol") for value in ("-1", "nan", "inf")),
    *((f"truth.tum truth.tum -u m -d {value}", "-d") for value in ("inf", "nan", "-1", "0")),
    ("truth.tum truth.tum -d 1e300", "-d 1e+300"),
    *((f"truth.tum short.tum -d 100 -u {unit}{every}", "the path has no such spans") for unit in "fmsr" for every in ("", " --all-pairs")),
    ("truth.tum late.tum", "the truth is from 0.000 to 9.967 s, the estimate from 1000000004.700 to 1000000009.967 s; with --t-offset "
                           "-1000000000 159 of its poses have a true one"),
    ("truth.tum shifted.tum", "with --t-offset -77.25 300 of its poses have a true one"),
    ("truth.tum later.tum", "2 of 300 estimated poses have a true one, over 0.033 s: the truth is from 0.000 to 9.967 s"),
    *((files, "still.tum: all 300 matched poses coincide") for files in ("truth.tum still.tum", "still.tum truth.tum")),
    ("truth.tum still.tum --align sim3", "coincide"),
    ("positions.csv truth.tum -r angle_deg", "it needs orientations"),
    *((files, "all without times, so they cannot be paired by row")
      for files in ("poses.txt half.txt", "poses.txt fewer.txt --align none", "half.txt poses.txt --align se3")),
    ("gap.tum truth.tum --align none --max-gap 5", "--interpolate"),
]
ACCEPTED = [
    ("truth.tum once_a_second.tum", ""), ("frames.tum frames.tum", ""),
    ("truth.tum us.csv", "\nmatched   300"), ("truth.tum ms.tum --columns t[ms],x,y,z", "\nmatched   300"),
    ("truth.tum mm.tum", "warning   its positions are 1000 times the true ones; --columns \"t[s] tx[mm] ty[mm] tz[mm] qx qy qz qw\" cuts"),
    ("mm.tum truth.tum", "warning   its positions are 0.001 times the true ones; --truth-columns \"t[s] tx[mm] ty[mm] tz[mm] qx"),
    ("truth.tum degrees.tum", "warning   its positions are 57.3 times the true ones; --align sim3 cuts the error from "),
    ("truth.tum ahead.tum", "warning   the clocks differ; --t-offset -0.400 cuts the error from "),
    ("truth.tum ahead.tum --t-offset -0.3", "warning   the clocks differ; --t-offset -0.400 cuts the error from "),
    ("truth.tum gps.tum", "warning   the clocks differ; --t-offset 3.000 cuts the error from "),
    ("truth.tum turned.tum", "warning   the bodies are turned by 73.74 deg; --turn-body 0.00,73.74,0.00 cuts the error from 73.7 to "),
    ("truth.tum turned.tum --turn-body 0,73.74,0", "APE none [deg]                      300 100.0 % 0.00020471"),
    ("helix.tum mirrored.tum", "warning   its y axis is mirrored; --columns \"t[s] tx -ty tz qx qy qz qw\" cuts the error from "),
    ("truth.tum flat.tum --align yaw", "warning   its y axis is mirrored"), ("truth.tum flat.tum --align se3", "\nalignment se3\n\n"),
    ("truth.tum noisy.tum", "\nalignment none\nwarning   sim3"), ("truth.tum noisy.tum --align se3", "\nalignment se3\n\n"),
    ("truth.tum late.tum --t-offset -1000000000", ""),
    ("truth.tum still.tum -r angle_deg", ""),  # a camera may turn in place
    ("truth.tum short.tum", ""),
    ("positions.csv truth.tum", "300 100.0 %" + 5 * "         0" + "\nAPE origin [m]                    a file has only positions\n"),
    ("truth.tum named.csv", "NEES none, position [1]             300 100.0 %         -         2         2"),
    ("stands.tum noisy.tum", "warning   sim3: the scale "),
    ("stands.tum noisy.tum --align sim3", "warning   sim3: the scale "),
    ("gap.tum truth.tum --align none --interpolate",
     "matched   199 of 300 poses (truth interpolated at the estimate's stamps, across at most 0.1 s)"),
    ("gap.tum truth.tum --align none --interpolate --max-gap 5", "matched   300 of 300 poses"),
    ("straight.tum two.tum", "covered   120 of 300 true poses, 40.0 % of the time; 9.967 m walked"),
    ("straight.tum first.tum", "covered   60 of 300 true poses, 20.0 % of the time; 1.967 m walked"),
    ("straight.tum first.tum", "APE none [m]                         60  20.0 %"),
]


def check_input(program):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in FILES.items():
            (pathlib.Path(folder) / name).write_text(text)
        for arguments, text in [*REFUSED, *ACCEPTED]:
            ran = run(program, *arguments.split(), cwd=folder)
            refused = (arguments, text) in REFUSED
            check(f"{arguments}: exit code", ran.returncode, 2 if refused else 0)
            check(f"{arguments}: prints {text}: {ran.stderr}{ran.stdout}", text in (ran.stderr if refused else ran.stdout), True)
            check(f"{arguments}: lines of the error", ran.stderr.count("\n"), 1 if refused else 0)
        sure = run(program, "truth.tum", "sure.tum", "--json", cwd=folder).stdout
        check("a covariance that is too small gives no number", "inf" not in sure and ("a value is not finite" in sure or "not positive definite" in sure), True)


# --- a result folder ---

def table(path):
    return np.array([[float(x) for x in line.split()] for line in open(path) if not line.startswith("#")])


def innovations(folder, begin):
    lines = open(folder / "frames.csv").read().splitlines()
    names = lines[0].split(",")
    rows = [line.split(",") for line in lines[1:] if int(line.split(",")[0]) * 1e-9 >= begin - 1e-9]
    for sensor in ("vision", "gyro", "plan_velocity", "height"):
        at, dof = names.index("nis_" + sensor), names.index("dof_" + sensor)
        yield sensor, [(float(r[at]), int(r[dof])) for r in rows if r[at] != "" and int(r[dof]) > 0]


def check_result(folder):
    metrics = {name: m["value"] for name, m in json.load(open(folder / "score.json"))["metrics"].items()}
    truth, estimate = table(folder / "truth.tum"), table(folder / "estimate_cov.txt")
    plan, waist, waist_plan = table(folder / "plan.tum"), table(folder / "waist_truth.tum"), table(folder / "waist_plan.tum")
    begin = next(r[0] for r in waist_plan if np.linalg.norm(r[1:4] - waist_plan[0, 1:4]) > 0.001)
    keep = lambda rows: rows[rows[:, 0] >= begin]
    truth, estimate, plan = keep(truth), keep(estimate), keep(plan)
    t, T, E, P = truth[:, 0], *(np.array([pose(r) for r in rows]) for rows in (truth, estimate, plan))
    rms = lambda v: math.sqrt(np.mean(np.square(v)))
    expected = {}
    for name, kind in (("rmse_m", "none"), ("ate_se3_rmse_m", "se3"), ("ate_yaw_rmse_m", "yaw"), ("ate_sim3_rmse_m", "sim3")):
        expected[name] = rms(ape(T, apply(similarity(kind, T, E), E)))
    expected["scale_error_percent"] = 100 * (1 / similarity("sim3", T, E)[0] - 1)
    expected["poses_matched"] = len(t)
    expected["rotation_rmse_deg"] = rms(ape(T, E, "angle_deg"))
    expected["end_yaw_error_deg"] = abs(math.degrees(yaw(T[-1, :3, :3] @ E[-1, :3, :3].T)))
    if pairs := pairs_all(walked(T), 1):
        expected["rpe_1m_m"], expected["rpe_1m_deg"] = rms(rpe(T, E, pairs)), rms(rpe(T, E, pairs, "angle_deg"))
    expected["end_position_error_m"] = np.linalg.norm(E[-1, :3, 3] - T[-1, :3, 3])
    expected["path_length_m"] = walked(T)[-1]
    expected["drift_percent"] = 100 * expected["end_position_error_m"] / expected["path_length_m"]
    expected["height_range_m"], expected["true_height_range_m"] = np.ptp(E[:, 2, 3]), np.ptp(T[:, 2, 3])
    expected["plan_rmse_m"] = rms(ape(T, P))
    end, planned, start = pose(waist[-1]), pose(waist_plan[-1]), pose(waist_plan[0])
    heading = yaw(start[:3, :3])
    shift = (end - planned)[:2, 3] @ np.array([[math.cos(heading), -math.sin(heading)], [math.sin(heading), math.cos(heading)]])
    expected["plan_drift_x_m"], expected["plan_drift_y_m"] = shift
    expected["plan_drift_yaw_deg"] = math.degrees(yaw(end[:3, :3] @ planned[:3, :3].T))
    nees = {"orientation": [], "position": []}
    for Q, X, row in zip(T, E, estimate):
        for part, error, first in (("orientation", log(X[:3, :3].T @ Q[:3, :3]), 8), ("position", Q[:3, 3] - X[:3, 3], 14)):
            C = np.zeros((3, 3))
            C[np.triu_indices(3)] = row[first:first + 6]
            C = C + np.triu(C, 1).T
            nees[part].append(error @ np.linalg.inv(C) @ error)
    for part, values in nees.items():
        expected[f"nees_{part}_mean"] = np.mean(values)
    for sensor, values in innovations(folder, begin):
        if len(values) < 2:
            continue
        square, dof = np.array(values).T
        expected[f"nis_{sensor}_mean"] = square.sum() / dof.sum()
    for name, value in expected.items():
        check(name, metrics[name], value)
    others = sorted(set(metrics) - set(expected))
    print(f"{len(expected)} metrics recomputed; not determined by these files: {', '.join(others)}")


if len(sys.argv) == 2:
    check_score(sys.argv[1])
    check_input(sys.argv[1])
else:
    check_result(pathlib.Path(sys.argv[2]))
print(f"{checks} numbers compared, {len(faults)} differ")
print("\n".join(faults[:40]))
sys.exit(1 if faults else 0)
