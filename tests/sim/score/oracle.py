#!/usr/bin/env python3
"""Computes oracle.inc: what sim/score must say of one pair of trajectories, by other means than sim/score's.

Plain Python, no library: rotations as lists, the best turn as Horn's quaternion (1987) found by power iteration instead
of a singular value decomposition, the best yaw by search, spans by trying all pairs. Run it to write oracle.inc anew.
"""
import math
import pathlib

N = 60


def matmul(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def matvec(A, v):
    return [sum(A[i][k] * v[k] for k in range(3)) for i in range(3)]


def transpose(A):
    return [list(row) for row in zip(*A)]


def rotation(v):
    """Rodrigues."""
    a = math.sqrt(sum(x * x for x in v))
    x, y, z = (c / a for c in v)
    c, s = math.cos(a), math.sin(a)
    t = 1 - c
    return [[c + x * x * t, x * y * t - z * s, x * z * t + y * s],
            [y * x * t + z * s, c + y * y * t, y * z * t - x * s],
            [z * x * t - y * s, z * y * t + x * s, c + z * z * t]]


def angle(R):
    """By sine and cosine: exact near 0 too."""
    sine = math.sqrt((R[2][1] - R[1][2]) ** 2 + (R[0][2] - R[2][0]) ** 2 + (R[1][0] - R[0][1]) ** 2) / 2
    return math.atan2(sine, (R[0][0] + R[1][1] + R[2][2] - 1) / 2)


def truth(i):
    s = 0.1 * i
    return rotation([0.1 * math.sin(s), 0.2 * math.cos(2 * s), s + 0.05]), [math.cos(s), math.sin(s), 0.3 * math.sin(2 * s)]


def estimate(i):
    R, p = truth(i)
    e = rotation([0.02 * math.sin(1.3 * i + 1), 0.02 * math.cos(0.7 * i), 0.02 * math.sin(2.1 * i + 3)])
    p = [p[0] + 0.05 * math.sin(1.7 * i), p[1] + 0.05 * math.cos(2.3 * i), p[2] + 0.05 * math.sin(0.9 * i + 2)]
    G = rotation([0.3, -0.2, 0.5])
    return matmul(G, matmul(R, e)), [1.1 * x + t for x, t in zip(matvec(G, p), (1, 2, 3))]


T = [truth(i) for i in range(N)]
E = [estimate(i) for i in range(N)]


def mean_of(points):
    return [sum(p[k] for p in points) / len(points) for k in range(3)]


def horn(a, b):
    """The turn R that makes sum |a - R b|² least, of centred points."""
    S = [[sum(q[i] * p[j] for p, q in zip(a, b)) for j in range(3)] for i in range(3)]  # b aᵀ
    K = [[S[0][0] + S[1][1] + S[2][2], S[1][2] - S[2][1], S[2][0] - S[0][2], S[0][1] - S[1][0]],
         [S[1][2] - S[2][1], S[0][0] - S[1][1] - S[2][2], S[0][1] + S[1][0], S[2][0] + S[0][2]],
         [S[2][0] - S[0][2], S[0][1] + S[1][0], -S[0][0] + S[1][1] - S[2][2], S[1][2] + S[2][1]],
         [S[0][1] - S[1][0], S[2][0] + S[0][2], S[1][2] + S[2][1], -S[0][0] - S[1][1] + S[2][2]]]
    shift = sum(abs(x) for row in K for x in row)
    q = [0.5, 0.5, 0.5, 0.5]
    for _ in range(20000):
        q = [sum((K[i][k] + (shift if i == k else 0)) * q[k] for k in range(4)) for i in range(4)]
        n = math.sqrt(sum(x * x for x in q))
        q = [x / n for x in q]
    w, x, y, z = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


IDENTITY = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]


def similarity(kind):
    """Scale, turn and shift that bring E onto T."""
    a, b = [p for _, p in T], [p for _, p in E]
    ma, mb = mean_of(a), mean_of(b)
    ca, cb = [[x - m for x, m in zip(p, ma)] for p in a], [[x - m for x, m in zip(p, mb)] for p in b]
    about_means = lambda s, R: (s, R, [x - s * y for x, y in zip(ma, matvec(R, mb))])
    if kind == "none":
        return 1, IDENTITY, [0, 0, 0]
    if kind == "origin":
        R = matmul(T[0][0], transpose(E[0][0]))
        return 1, R, [x - y for x, y in zip(a[0], matvec(R, b[0]))]
    if kind == "yaw_position":
        turn = lambda t: [[math.cos(t), -math.sin(t), 0], [math.sin(t), math.cos(t), 0], [0, 0, 1]]
        cost = lambda t: sum(sum((x - y) ** 2 for x, y in zip(p, matvec(turn(t), q))) for p, q in zip(ca, cb))
        best = min((k * 0.01 for k in range(-315, 316)), key=cost)
        slope = lambda t: -sum(p[0] * (-math.sin(t) * q[0] - math.cos(t) * q[1]) +
                               p[1] * (math.cos(t) * q[0] - math.sin(t) * q[1]) for p, q in zip(ca, cb))
        low, high = best - 0.01, best + 0.01
        for _ in range(100):
            middle = (low + high) / 2
            low, high = (middle, high) if slope(middle) < 0 else (low, middle)
        return about_means(1, turn((low + high) / 2))
    R = horn(ca, cb)
    scale = sum(sum(x * y for x, y in zip(p, matvec(R, q))) for p, q in zip(ca, cb)) / sum(sum(x * x for x in q) for q in cb)
    return {"se3": lambda: about_means(1, R), "sim3": lambda: about_means(scale, R),
            "scale": lambda: (scale, IDENTITY, [0, 0, 0])}[kind]()


def aligned(kind):
    s, R, t = similarity(kind)
    return [(matmul(R, A), [s * x + y for x, y in zip(matvec(R, p), t)]) for A, p in E]


def distance(p, q):
    return math.sqrt(sum((x - y) ** 2 for x, y in zip(p, q)))


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def relative(i, j):
    """Translation and rotation of (T_i⁻¹ T_j)⁻¹ (E_i⁻¹ E_j)."""
    def between(X, Y):
        return matmul(transpose(X[0]), Y[0]), matvec(transpose(X[0]), [y - x for x, y in zip(X[1], Y[1])])
    (Rt, pt), (Re, pe) = between(T[i], T[j]), between(E[i], E[j])
    return distance(pt, pe), angle(matmul(transpose(Rt), Re))


def walked(i, j):
    return sum(distance(E[k][1], E[k + 1][1]) for k in range(i, j))


def consecutive_metres(delta):
    marks, i = [], 0
    while i < N - 1:
        j = next((j for j in range(i + 1, N) if walked(i, j) >= delta), None)
        if j is None:
            break
        marks.append(j)
        i = j
    return list(zip(marks, marks[1:]))


def all_metres(delta):
    pairs = []
    for i in range(N - 1):
        j = min(range(i + 1, N), key=lambda j: abs(walked(i, j) - delta))
        if abs(walked(i, j) - delta) <= 0.1 * delta:
            pairs.append((i, j))
    return pairs


rows = []
for kind in ("none", "origin", "yaw_position", "se3", "sim3", "scale"):
    A = aligned(kind)
    e = [distance(p, q) for (_, p), (_, q) in zip(T, A)]
    turns = [angle(matmul(transpose(R), S)) for (R, _), (S, _) in zip(T, A)]
    m, ordered = sum(e) / N, sorted(e)
    rows += [(kind + ".rmse", rms(e)), (kind + ".mean", m), (kind + ".median", (ordered[29] + ordered[30]) / 2),
             (kind + ".std", rms([x - m for x in e])), (kind + ".min", ordered[0]), (kind + ".max", ordered[-1]),
             (kind + ".rotation_rmse", rms(turns)), (kind + ".scale", similarity(kind)[0])]
for name, pairs in (("frames_5", [(i, i + 5) for i in range(0, N - 5, 5)]), ("frames_7_all", [(i, i + 7) for i in range(N - 7)]),
                    ("metres_0.5", consecutive_metres(0.5)), ("metres_0.5_all", all_metres(0.5)),
                    ("seconds_0.2", [(i, i + 6) for i in range(0, N - 6, 6)])):  # 30 frames to the second
    e = [relative(i, j) for i, j in pairs]
    rows += [(name + ".n", len(pairs)), (name + ".translation_rmse", rms([x for x, _ in e])),
             (name + ".rotation_rmse", rms([x for _, x in e]))]
rows.append(("path_length", walked(0, N - 1)))

with open(pathlib.Path(__file__).with_name("oracle.inc"), "w") as out:
    out.write("// Written by oracle.py.\n")
    for name, value in rows:
        out.write(f'{{"{name}", {float(value)!r}}},\n')
