#!/usr/bin/env python3
"""Updates the measured parts of README.md and scenarios/README.md, or checks a sample of them.

    tools/figures/front_page.py [WORK_FOLDER]           runs ten seeds of each scenario (about 8 minutes on two idle cores; rerun
                                                        the command to resume), writes front_page.json, the pictures (needs
                                                        chromium, node and ffmpeg) and both pages
    tools/figures/front_page.py --pictures OUT [WORK_FOLDER] writes only the pictures, to the folder OUT
    tools/figures/front_page.py --check [WORK_FOLDER]   measures one or two seeds of each column again; exit code 1 if a page differs
                                                        from front_page.json, or a stored value from the new one by more than
                                                        the tolerance (takes seconds if the walks are in $GAITSLAM_CACHE)

$GAITSLAM selects the program, default tools/gaitslam. The interval of a mean over the seeds is Student's t, like the one by
which regress judges limits on a mean.
"""
import json
import os
import pathlib
import platform
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
STORED = ROOT / "tools/figures/front_page.json"
SCENARIOS = ("tangent_circle", "perpendicular_circle", "hall", "slippery_laps")
SEEDS, SAMPLE = "1..10", ("1", "2")  # a walk of slippery_laps takes long: one seed
T_95 = 2.262  # Student's t of a 95 % interval from ten values
RELATIVE = 0.2  # tolerance of --check; other processors render other pixels
# Metric, text, factor to the unit shown, format, absolute tolerance in that unit.
ROWS = (
    ("ate_se3_rmse_m", "ATE after SE(3) alignment, mm", 1e3, "{:.1f}", 0.5),
    ("rmse_m", "position error, not aligned, mm", 1e3, "{:.1f}", 0.5),
    ("plan_rmse_m", "the walking plan alone, mm", 1e3, "{:.0f}", 0.5),
    ("end_position_error_m", "position error at the end, mm", 1e3, "{:.1f}", 1),
    ("end_yaw_error_deg", "heading error at the end, deg", 1, "{:.2f}", 0.05),
    ("loop_landmarks", "landmarks that close the loop", 1, "{:.0f}", 2),
    ("nees_position_mean", "NEES of the position (3 expected): mean, 95 % interval, n", 1, "{:.1f}", 0.3),
)
ODOMETRY = "ATE of the same sensors without images (`estimator: odometry`), mm"
PAPER = "ATE of the paper's filter here, mm"


def gaitslam(*arguments):
    program = os.environ.get("GAITSLAM", ROOT / "tools/gaitslam")
    done = subprocess.run([program, *map(str, arguments)], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if done.returncode > 1:  # 1: a limit was missed, which the table shows
        sys.exit(f"gaitslam {' '.join(map(str, arguments))}: exit code {done.returncode}")
    return done.stdout


def columns():
    """For each column of results: its name, scenario, estimator and the metrics that it shows."""
    for scenario in SCENARIOS:
        yield scenario, scenario, "filter", [row[0] for row in ROWS]
        yield scenario + ", odometry", scenario, "odometry", [ROWS[0][0]]
        if (ROOT / f"scenarios/{scenario}_paper.yaml").exists():
            yield scenario + ", paper", scenario + "_paper", "filter", [ROWS[0][0]]


def measured(work, seeds=None):
    """For each column and metric: the statistics over the seeds, or else over the sample, and the values of the sample."""
    results = {}
    for name, scenario, estimator, metrics in columns():
        out = work / f"{scenario}_{estimator}"
        seeds_of_sample = SAMPLE[:1] if scenario == "slippery_laps" else SAMPLE
        gaitslam("run", f"scenarios/{scenario}.yaml", f"estimator={estimator}", "--seeds", seeds or ",".join(seeds_of_sample), "--jobs", os.cpu_count(),
                 "--cached", "--out", out, "--force", "-q")
        summary = json.loads((out / "summary.json").read_text())["metrics"]
        sample = [json.loads((out / f"seed-{seed}/score.json").read_text())["metrics"] for seed in seeds_of_sample]
        results[name] = {metric: {**summary[metric], "sample": [score[metric]["value"] for score in sample]} for metric in metrics}
    return results


def cell(metric, statistics, factor, form):
    """The median and worst value; of a NEES, whose single values vary by chance, the mean with its interval."""
    def text(value):
        return form.format(factor * value)

    if not statistics:
        return ""
    if not metric.startswith("nees"):
        return f"{text(statistics['median'])} ({text(statistics['worst'])})"
    if "mean" not in statistics:
        return "not measured"
    half = T_95 * statistics["sd"] / statistics["n"] ** 0.5
    return f"{text(statistics['mean'])} [{text(statistics['mean'] - half)}, {text(statistics['mean'] + half)}], {statistics['n']}"


def table(stored):
    results = stored["columns"]
    lines = ["| ten seeds: median (worst) | " + " | ".join(f"`{s}`" for s in SCENARIOS) + " |",
             "|---|" + "---|" * len(SCENARIOS)]

    def add(text, suffix, metric, factor, form):
        cells = (cell(metric, results.get(s + suffix, {}).get(metric), factor, form) for s in SCENARIOS)
        lines.append(f"| {text} | " + " | ".join(cells) + " |")

    for metric, text, factor, form, _ in ROWS:
        add(text, "", metric, factor, form)
    metric, _, factor, form, _ = ROWS[0]
    add(ODOMETRY, ", odometry", metric, factor, form)
    add(PAPER, ", paper", metric, factor, form)
    return "\n".join(lines) + (f"\n\nMeasured at revision {stored['revision']} by `tools/figures/front_page.py` on "
                               f"{stored['machine']}. `.ci/run` measures one or two seeds of each column again.\n")


def key_figures(stored):
    ate, without, paper = (f"{1e3 * stored['columns']['tangent_circle' + column]['ate_se3_rmse_m']['median']:.1f} mm"
                           for column in ("", ", odometry", ", paper"))
    return f"Median ATE over ten seeds: {ate}; {without} without images, {paper} with the filter of 2006.\n"


def pages(stored):
    """Yields each page with its measured parts, which are between markers with their names."""
    for name, parts in {"README.md": {"key figures": key_figures(stored)},
                        "scenarios/README.md": {"scores": table(stored)}}.items():
        page = (ROOT / name).read_text()
        for part, body in parts.items():
            begin, end = f"<!-- {part}: tools/figures/front_page.py -->\n", f"<!-- end of {part} -->\n"
            at, to = page.index(begin) + len(begin), page.index(end)
            page = page[:at] + body + page[to:]
        yield ROOT / name, page


def differences(stored, now):
    """Yields one line for each sample value that differs from the new measurement by more than the tolerance."""
    for name, _, _, metrics in columns():
        for metric, _, factor, _, absolute in ROWS:
            if metric not in metrics:
                continue
            pairs = zip(SAMPLE, stored["columns"].get(name, {}).get(metric, {}).get("sample", [None] * 2), now[name][metric]["sample"])
            for seed, then, value in pairs:
                if None in (then, value) or abs(value - then) > RELATIVE * abs(then) + absolute / factor:
                    yield f"{name}, seed {seed}: {metric} was {then}, is {value}"


def check(work):
    stored = json.loads(STORED.read_text())
    wrong = [f"{path} differs from tools/figures/front_page.json" for path, page in pages(stored) if path.read_text() != page]
    wrong += differences(stored, measured(work))
    for line in wrong:
        print(f"front page: {line}", file=sys.stderr)
    if wrong:
        sys.exit(f"front page: measured at revision {stored['revision']}, out of date: run tools/figures/front_page.py")
    print(f"front page: one or two seeds of each column agree within {100 * RELATIVE:.0f} %")


def machine():
    model = [line.split(":")[1].strip() for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines()
             if line.startswith("model name")]
    return f"{model[0] if model else platform.machine()}, {os.cpu_count()} cores"


def revision():
    git = ("git", "-C", str(ROOT))
    changed = subprocess.run([*git, "diff-index", "--quiet", "HEAD", "--"], check=False).returncode != 0
    return subprocess.check_output([*git, "rev-parse", "--short=12", "HEAD"], text=True).strip() + ("+" if changed else "")


def animation(work, out):
    video = work / "walk.mp4"
    gaitslam("video", work / "first/seed-1", "--out", video, "--force")
    subprocess.run(["ffmpeg", "-loglevel", "error", "-i", str(video), "-vf", "setpts=PTS/4,fps=6,scale=800:-1:flags=lanczos",
                    "-c:v", "libwebp_anim", "-quality", "35", "-compression_level", "4", "-loop", "0", "-y",
                    out / "walk.webp"], check=True)


def view_picture(work, out, seconds, theme, name, *arguments):
    """Takes a picture of the page whose URL a command prints, at a time (s) of the walk."""
    program = os.environ.get("GAITSLAM", ROOT / "tools/gaitslam")
    with subprocess.Popen([program, *map(str, arguments)], cwd=ROOT, stdout=subprocess.PIPE, text=True) as shown:
        url = next(line for line in shown.stdout if "token" in line).split()[-1]
        picture = work / f"{name}.png"
        subprocess.run(["node", ROOT / "tests/tools/use_page.cjs", "picture", url, work / "profile", str(seconds), picture, "1200", "860",
                        theme], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["ffmpeg", "-loglevel", "error", "-y", "-i", picture, "-quality", "80", out / f"{name}.webp"], check=True)
        shown.terminate()
        shown.stdout.read()


def pictures(work, out):
    """Makes all pictures."""
    gaitslam("run", "scenarios/tangent_circle.yaml", "--cached", "--out", work / "first", "--force", "-q")
    animation(work, out)
    gaitslam("replay", work / "first/seed-1", "slam.vision.sigma_px=3", "--out", work / "other", "--force", "-q")
    view_picture(work, out, 24, "dark", "view_live", "run", "scenarios/tangent_circle.yaml", "--view", "--wait", "--out",
                 work / "view", "--force")
    view_picture(work, out, 32.6, "light", "view_playback", "view", work / "first/seed-1", work / "other")


def main():
    arguments = sys.argv[1:]
    mode = arguments.pop(0) if arguments and arguments[0].startswith("--") else ""
    out = pathlib.Path(arguments.pop(0)).resolve() if mode == "--pictures" else ROOT / "tools/figures"
    work = pathlib.Path((arguments or [ROOT / "results/front_page"])[0]).resolve()
    os.environ.setdefault("GAITSLAM_CACHE", str(work / "cache"))
    if mode == "--check":
        return check(work)
    before = revision()  # taken now, because the pictures written below change the tree
    pictures(work, out)
    if mode == "--pictures":
        return None
    stored = {"revision": before, "machine": machine(), "columns": measured(work, SEEDS)}
    STORED.write_text(json.dumps(stored, indent=1) + "\n")
    for path, page in pages(stored):
        path.write_text(page)


if __name__ == "__main__":
    main()
