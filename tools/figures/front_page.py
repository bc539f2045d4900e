#!/usr/bin/env python3
"""Updates the measured parts of the front page (README.md): its table, its first run and its animated picture.

    tools/figures/front_page.py [WORK_FOLDER]

Walks ten seeds of each scenario (about 8 minutes on two idle cores; rerun the command to resume), writes
tools/figures/front_page.md and tools/figures/walk.webp, and puts the former between README.md's markers.
"""
import json
import os
import pathlib
import platform
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
STORED = ROOT / "tools/figures/front_page.md"
SCENARIOS = ("tangent_circle", "perpendicular_circle", "hall", "slippery_laps")
SEEDS = "1..10"
# Metric of summary.json, text, factor to the unit shown, format.
ROWS = (
    ("ate_se3_rmse_m", "ATE after SE(3) alignment, mm", 1e3, "{:.1f}"),
    ("rmse_m", "position error, not aligned, mm", 1e3, "{:.1f}"),
    ("plan_rmse_m", "the walking plan alone, mm", 1e3, "{:.0f}"),
    ("end_position_error_m", "position error at the end, mm", 1e3, "{:.1f}"),
    ("end_yaw_error_deg", "heading error at the end, deg", 1, "{:.2f}"),
    ("loop_landmarks", "landmarks that close the loop", 1, "{:.0f}"),
    ("nees_position_mean", "NEES of the position (3 expected)", 1, "{:.1f}"),
)


def gaitslam(*arguments):
    done = subprocess.run([ROOT / "tools/gaitslam", *arguments], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if done.returncode > 1:  # 1: a limit was missed, which the table shows
        sys.exit(f"gaitslam {' '.join(map(str, arguments))}: exit code {done.returncode}")
    return done.stdout


def summary(work, scenario, estimator="filter"):
    out = work / f"{scenario}_{estimator}"
    gaitslam("run", f"scenarios/{scenario}.yaml", f"estimator={estimator}", "--seeds", SEEDS, "--jobs", str(os.cpu_count()), "--cached",
             "--out", str(out), "--force")
    return json.loads((out / "summary.json").read_text())["metrics"]


def cell(metric, factor, form):
    return f"{form.format(factor * metric['median'])} ({form.format(factor * metric['worst'])})"


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":")[1].strip()
    return platform.machine()


def table(work):
    ours = {s: summary(work, s) for s in SCENARIOS}
    blind = {s: summary(work, s, "odometry") for s in SCENARIOS}
    paper = {s: summary(work, s + "_paper") for s in SCENARIOS if (ROOT / f"scenarios/{s}_paper.yaml").exists()}
    lines = ["| ten seeds: median (worst) | " + " | ".join(f"`{s}`" for s in SCENARIOS) + " |",
             "|---|" + "---|" * len(SCENARIOS)]
    for name, text, factor, form in ROWS:
        lines.append(f"| {text} | " + " | ".join(cell(ours[s][name], factor, form) for s in SCENARIOS) + " |")
    name, _, factor, form = ROWS[0]
    for text, results in (("ATE of the same sensors without images (`estimator: odometry`), mm", blind),
                          ("ATE of the paper's filter here, mm", paper)):
        cells = (cell(results[s][name], factor, form) if s in results else "" for s in SCENARIOS)
        lines.append(f"| {text} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + f"\n\nMeasured by `tools/figures/front_page.py` on {processor()}, {os.cpu_count()} cores.\n"


def shortened(output):
    """The head, the metrics that have a limit and the end."""
    lines = output.rstrip().splitlines()
    return "\n".join(line for i, line in enumerate(lines) if i < 1 or i >= len(lines) - 5 or "=" in line)


def first_run(work):
    command = ("run", "scenarios/tangent_circle.yaml")
    text = gaitslam(*command, "--out", str(work / "first"), "--force")
    text = text.replace(str(work / "first"), "results/tangent_circle")
    return f"```\n$ tools/gaitslam {' '.join(command)}\n{shortened(text)}\n```\n"


def picture(work):
    video = work / "walk.mp4"
    gaitslam("video", str(work / "first/seed-1"), "--out", str(video), "--force")
    subprocess.run(["ffmpeg", "-loglevel", "error", "-i", str(video), "-vf", "setpts=PTS/4,fps=8,scale=960:-1:flags=lanczos",
                    "-c:v", "libwebp_anim", "-quality", "45", "-compression_level", "6", "-loop", "0", "-y",
                    str(ROOT / "tools/figures/walk.webp")], check=True)


def put_into_readme(text):
    readme = ROOT / "README.md"
    page = readme.read_text()
    for part, body in text.items():
        begin, end = f"<!-- {part}: tools/figures/front_page.py -->\n", f"<!-- end of {part} -->\n"
        at, to = page.index(begin) + len(begin), page.index(end)
        page = page[:at] + body + page[to:]
    readme.write_text(page)
    STORED.write_text("\n".join(text.values()))


def main():
    work = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "results/front_page").resolve()
    os.environ["GAITSLAM_CACHE"] = str(work / "cache")
    text = {"scores": table(work), "first run": first_run(work)}
    picture(work)
    put_into_readme(text)


if __name__ == "__main__":
    main()
