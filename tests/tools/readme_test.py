# Runs the commands of all documents as they stand, with a walk of one step in place of each scenario. Commands that take
# long, wait for input or need a cluster are only parsed, as is the rest of their block. Usage: readme_test.py PROGRAM
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PARSED = r"gaitslam (view|tune|reproduce|regress|baseline|sweep(?!.*--dry-run))|--view|--backend|gdbserver|policy\.onnx|from_s|walk\.commands"
START = (
    f"mkdir -p start/tools && cd start && ln -s {ROOT}/tools/examples {sys.argv[1]} tools && ln -s {ROOT}/sim . && cp -rL {ROOT}/scenarios . && "
    "step='{walk: {commands: [{stand: {duration_s: 0.3}}, {straight: {forward_m: 0.15}}]}, camera: {rate_hz: 10}, slam: {}}' && "
    "for file in scenarios/*.yaml; do echo \"$step\" >$file; done && "
    "for name in mine my_slam visual_odometry; do ln -s tools/examples/gyro_and_plan.py $name; done && "
    "tools/gaitslam run scenarios/tangent_circle.yaml --seeds 1,2 && cd results && cp -r tangent_circle before && cp -r before after && "
    "mkdir tune-circles && echo slam.vision.sigma_px: 1 >tune-circles/best.yaml")


def commands(page):
    for block in re.findall(r"^```\n(.*?)^```|((?:^    .*\n)+)", page.read_text(), re.MULTILINE | re.DOTALL):
        parsed = False
        for line in "".join(block).replace("\\\n", " ").split("\n"):
            if line.strip().startswith("tools/gaitslam "):
                parsed = parsed or re.search(PARSED, line) is not None
                yield line.split(" #")[0] + " --not-an-option" * parsed, parsed


def shell(folder, command):
    return subprocess.run(["bash", "-c", command], cwd=folder, env={"GAITSLAM_CACHE": place, "PATH": "/usr/bin:/bin"},
                          capture_output=True, text=True, timeout=100, check=False)


with tempfile.TemporaryDirectory() as place:
    shell(place, START).check_returncode()
    count, failures = 0, []
    pages = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    for page in filter(lambda page: any(commands(page)), map(ROOT.joinpath, pages)):
        fresh = " && rm -r page/results" * (page.parent == ROOT)  # the front page makes its own results
        shell(place, "rm -rf page && cp -r start page" + fresh).check_returncode()
        for command, parsed in commands(page):
            ran, count = shell(place + "/page", command), count + 1
            if ran.returncode if not parsed else "argument was not expected: --not-an-option" not in ran.stderr:
                failures.append(f"{page}: {command}\n{ran.stdout}{ran.stderr}")
sys.exit("\n".join(failures) or count < 40)
