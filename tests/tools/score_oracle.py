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


def check_input(program):
    """The cases of score_cases.txt."""
    with tempfile.TemporaryDirectory() as folder:
        for line in pathlib.Path(__file__).with_name("score_cases.txt").read_text().splitlines()[3:]:
            kind, what, *parts = line.split(" | ")
            file, text = pathlib.Path(folder) / what, parts[-1].replace("\\n", "\n")
            if kind == "header":
                file.write_text(text + "\n")
            elif kind == "file":
                rows = ({**vars(math), "i": i, "t": i / 30, "y": math.sin(i / 30)} for i in range(300))
                file.open("a").writelines(eval(f"f'{text}\\n'", row) for row in rows if eval(parts[0], row))
            else:
                refused, ran = kind == "refused", run(program, *what.split(), cwd=folder)
                check(f"{what}: exit code", ran.returncode, 2 if refused else 0)
                check(f"{what}: prints {text}: {ran.stderr}{ran.stdout}", text in (ran.stderr if refused else ran.stdout), True)
                check(f"{what}: lines of the error", ran.stderr.count("\n"), 1 if refused else 0)
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
