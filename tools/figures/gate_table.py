#!/usr/bin/python3
"""The README's table of the regression gate: what it does about planted changes, measured on recordings.
Usage: gate_table.py RECORDINGS [OUT_DIR], from the project's folder. RECORDINGS/tangent_circle has seed-1 to seed-10,
RECORDINGS/perpendicular_circle seed-1 to seed-3, each a result with its recording; $GAITSLAM is the program, else
tools/gaitslam. Nothing is walked: everything is a replay, `compare` of ten seeds with its own gates and `regress` of the
smoke suite against a baseline made here of the same recordings."""
import concurrent.futures
import csv
import itertools
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

PROGRAM = os.environ.get("GAITSLAM", "tools/gaitslam")
SUITE = "scenarios/suites/ci.yaml"
SEEDS = range(1, 11)
NOISE_SETS = 7  # of disjoint seeds: 21 pairs
JOBS = 2
SLOWER_MS = 0.5
PLANTED = [
    ("nothing: the same program again", []),
    ("gyro noise x 5", ["errors.gyro.sigma_rad_s=0.05"]),
    ("images one frame late", ["errors.image.latency_s=0.033"]),
    ("plan 2 % too large", ["errors.faults=[{plan_scaled: {from_s: 0, duration_s: 1000, factor: 1.02}}]"]),
    ("plan 4 % too large", ["errors.faults=[{plan_scaled: {from_s: 0, duration_s: 1000, factor: 1.04}}]"]),
    ("image noise taken for half, which halves the search ellipses", ["slam.vision.sigma_px=0.125"]),
    ("image noise taken for a fifth: ellipses below the scatter of matches", ["slam.vision.sigma_px=0.05"]),
    ("matches refused from 0.3 of their usual scatter on", ["slam.vision.gate_sigma_px=0.045"]),
]


def gaitslam(*words, log=None):
    """Exit code; what is printed goes to a file."""
    with open(log or os.devnull, "w") as out:
        return subprocess.run([PROGRAM, *map(str, words)], stdout=out, stderr=subprocess.STDOUT).returncode


def replay(folder, seeds, changes):
    """seeds: of a recording and of the noise. Every result lies in folder/seed-<noise>."""

    def one(pair):
        recorded, noise = pair
        result = folder / f"seed-{noise}"
        walk = RECORDINGS / "tangent_circle" / f"seed-{recorded}"
        code = gaitslam("replay", walk, "--scenario", "scenarios/tangent_circle.yaml", f"seed={noise}", *changes, "--out", result)
        if code == 2:
            sys.exit(f"gate_table.py: replay of {walk} with {changes} is refused")

    with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
        list(pool.map(one, seeds))
    return folder


def rows(verdicts):
    """Verdicts, all alike: (verdict, change in tolerances, text); limits missed."""
    metrics, missed = [], []
    for scenario in json.loads(verdicts.read_text())["scenarios"]:
        for m in scenario["metrics"]:
            before, now = m["baseline_median"], m["now_median"]
            if before is None or now is None:
                metrics.append((m["verdict"], 0, f"`{m['metric']}` {m['remark']}"))
                continue
            tolerance = max(m["tolerance_absolute"], m["tolerance_percent"] / 100 * abs(before))
            metrics.append((m["verdict"], abs(m["change"] or 0) / tolerance, f"`{m['metric']}` {before:.3g} -> {now:.3g}"))
        missed += [f"`{limit['limit']}` met by {limit['observed']}" for limit in scenario["limits"] if not limit["passed"]]
    return metrics, missed


def counted(metrics):
    words = [word for word, _, _ in metrics]
    return ", ".join(f"{words.count(word)} `{word}`" for word in dict.fromkeys(words))


def in_words(verdicts, code):
    metrics, missed = rows(verdicts)
    failed = [m for m in metrics if m[0] in ("FAIL", "MISSING")]
    worst = max(failed or metrics, key=lambda m: m[1])
    shown = [worst[2]] if worst[0] != "IDENTICAL" else []
    return "; ".join([counted(metrics), *shown, *missed[:2]]) + f": exit {code}"


def compared(before, after, log):
    verdicts = OUT / f"{log}.json"
    code = gaitslam("compare", before, after, "--json", verdicts, log=OUT / f"{log}.log")
    return verdicts, code


def regressed(name, *words):
    verdicts = OUT / f"{name}-smoke.json"
    code = gaitslam("regress", SUITE, "--baseline", OUT / "baseline.json", "--json", verdicts, *words, log=OUT / f"{name}-smoke.log")
    return in_words(verdicts, code) if verdicts.exists() else f"exit {code}, see {name}-smoke.log"


def slowed(folder):
    """A copy of results in which every frame of the filter took longer."""
    copy = folder.with_name(folder.name + "-slower")
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("recording"))
    for table in copy.rglob("timing.csv"):
        lines = list(csv.reader(table.open()))
        column = lines[0].index("filter [ms]")
        for line in lines[1:]:
            line[column] = f"{float(line[column]) + SLOWER_MS:.4f}"
        csv.writer(table.open("w"), lineterminator="\n").writerows(lines)
        timing = json.loads(table.with_suffix(".json").read_text())
        timing["frame_cpu_ms_median"] += SLOWER_MS
        table.with_suffix(".json").write_text(json.dumps(timing))
    return copy


def matches(folder):
    """How far matches lie from where they were expected: px, and in standard deviations of that."""
    px, sigmas = [], []
    for table in sorted(folder.glob("seed-*/searches.csv")):
        for row in csv.DictReader(table.open()):
            if not math.isfinite(float(row["found_u [px]"] or "nan")):
                continue  # not found, or not used
            du, dv = float(row["found_u [px]"]) - float(row["u [px]"]), float(row["found_v [px]"]) - float(row["v [px]"])
            uu, uv, vv = (float(row[f"S_{part} [px^2]"]) for part in ("uu", "uv", "vv"))
            px.append(du * du + dv * dv)
            sigmas.append(((vv * du * du - 2 * uv * du * dv + uu * dv * dv) / (uu * vv - uv * uv)) ** 0.5)
    beyond = [sum(s > limit for s in sigmas) for limit in (1.5, 0.6)]
    print(f"\n{len(px)} matches, {(sum(px) / len(px)) ** 0.5:.2f} px (rms) from where they were expected, the farthest at "
          f"{max(sigmas):.2f} sigma: half the ellipse would lose {beyond[0]} of them, a fifth of it {beyond[1]}.")


def show(*cells):
    print("|", " | ".join(cells), "|", flush=True)


if len(sys.argv) not in (2, 3):
    sys.exit(__doc__)
RECORDINGS = pathlib.Path(sys.argv[1])
OUT = pathlib.Path(sys.argv[2] if len(sys.argv) == 3 else "results/gate_table")
shutil.rmtree(OUT, ignore_errors=True)
OUT.mkdir(parents=True)

same = [(seed, seed) for seed in SEEDS]
baseline = replay(OUT / "baseline", same, [])
made = gaitslam("baseline", "update", SUITE, "--baseline", OUT / "baseline.json", "--recordings", RECORDINGS, "--jobs", JOBS,
                "--out", OUT / "smoke", "--reason", "as it is", log=OUT / "smoke.log")
if made != 0:
    sys.exit(f"gate_table.py: no baseline: see {OUT / 'smoke.log'}")
show("planted", "ten seeds, `compare`", "three seeds of both circles, `regress`")
show("---", "---", "---")
for number, (name, changes) in enumerate(PLANTED):
    folder = replay(OUT / str(number), same, changes)
    small = regressed(number, *changes, "--recordings", RECORDINGS, "--jobs", JOBS, "--out", OUT / f"{number}-smoke")
    show(name, in_words(*compared(baseline, folder, number)), small)
show(f"{SLOWER_MS} ms a frame slower (written into `timing.*`)", in_words(*compared(baseline, slowed(baseline), "slower")),
     regressed("slower", "--results", slowed(OUT / "smoke")))

noisy = [replay(OUT / f"noise-{k}", [(seed, 100 * k + seed) for seed in SEEDS], []) for k in range(1, NOISE_SETS + 1)]
pairs = list(itertools.combinations(range(NOISE_SETS), 2))
metrics, alarms = [], 0
for a, b in pairs:
    verdicts, code = compared(noisy[a], noisy[b], f"pair-{a + 1}-{b + 1}")
    metrics += rows(verdicts)[0]
    alarms += code != 0
show(f"nothing: {len(pairs)} pairs out of {NOISE_SETS} sets of the walks with other noise seeds",
     f"{counted(metrics)}; {alarms} false alarms", "-")
matches(baseline)
