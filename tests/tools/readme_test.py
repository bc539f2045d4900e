"""Runs the commands of all README files as they stand, on walks of a moment in place of the shipped scenarios. Commands that would
take long, wait for somebody or need a cluster are only parsed, with what follows them in their block. Usage: readme_test.py PROGRAM"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = sys.argv.pop()
PARSED = r'gaitslam (view|tune|reproduce|regress|baseline|sweep(?!.*--dry-run))|--view|--backend|gdbserver|policy\.npz|from_s|walk\.commands'
STEP = 'walk: {commands: [{stand: {duration_s: 0.3}}, {straight: {forward_m: 0.15}}]}\ncamera: {rate_hz: 10}\nslam: {}\n'
MOUNTED = ('sim', 'tools/examples')


def blocks(text):
    """The blocks of code in a page: commands of gaitslam, with continued lines joined and without comments."""
    for block in re.findall(r'^```\n(.*?)^```|((?:^    .*\n)+)', text, re.MULTILINE | re.DOTALL):
        lines = re.sub(r'\\\n', ' ', ''.join(block)).split('\n')
        yield [re.sub(r' +# .*', '', line.strip()) for line in lines if line.strip().startswith('tools/gaitslam ')]


class Readme(unittest.TestCase):
    def run_in(self, folder, command, code=0):
        ran = subprocess.run(['bash', '-c', command], cwd=folder, env={'GAITSLAM_CACHE': f'{folder}/cache', 'PATH': '/usr/bin:/bin'},
                             capture_output=True, text=True, timeout=100, check=False)
        self.assertEqual(code, ran.returncode, f'{command}\n{ran.stdout}{ran.stderr}')
        return ran.stderr

    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.start = pathlib.Path(place.name) / 'start'
        (self.start / 'tools').mkdir(parents=True)
        for name in MOUNTED:
            (self.start / name).symlink_to(ROOT / name)
        (self.start / 'tools/gaitslam').symlink_to(PROGRAM)
        shutil.copytree(ROOT / 'scenarios', self.start / 'scenarios')
        for scenario in (self.start / 'scenarios').glob('*.yaml'):
            scenario.write_text(STEP)
        for name in ('mine', 'my_slam', 'visual_odometry'):
            (self.start / name).symlink_to('tools/examples/gyro_and_plan.py')
        self.run_in(self.start, 'tools/gaitslam run scenarios/tangent_circle.yaml --seeds 1,2 && cp -r results/tangent_circle results/before && '
                                'cp -r results/tangent_circle results/after && mkdir results/tune-circles && '
                                'echo "slam.vision.sigma_px: 1" >results/tune-circles/best.yaml')

    def test_each_command_runs_as_it_stands(self):
        count = 0
        for page in ROOT.glob('**/*.md'):
            if 'build' in page.parts or not any(all_blocks := list(blocks(page.read_text()))):
                continue
            folder = self.start.parent / 'page'
            shutil.copytree(self.start, folder, symlinks=True, ignore=shutil.ignore_patterns('results') if page.parent == ROOT else None)
            for commands in all_blocks:
                parsed = False
                for command in commands:
                    count += 1
                    with self.subTest(page=page, command=command):
                        if parsed := parsed or re.search(PARSED, command):
                            self.assertIn('not expected: --not-an-option', self.run_in(folder, command + ' --not-an-option', 2))
                        else:
                            self.run_in(folder, command)
            shutil.rmtree(folder)
        self.assertGreater(count, 40)


unittest.main()
