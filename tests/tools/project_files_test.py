"""The project's own files: what each folder may include, the measured parts of the front page, the sources whose change makes
recordings stale, and the layout and rules of JavaScript. The linker cannot enforce the first, since Debian's headers of MuJoCo, OpenGL and OpenCV are in the compiler's
default path. Usage: project_files_test.py CMAKE"""
import graphlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / 'tools/figures'))
import front_page  # noqa: E402
# By folder, the prefixes of headers that its files may include.
RULES = dict(re.findall(r'^(\S+): (.+(?:\n    .+)*)', (ROOT / 'tests/tools/include_rules.txt').read_text(), re.MULTILINE))
# Headers that the run and the writer of recordings include but that do not affect a recording.
SHAPE_NOTHING = {'sim/result/result.h', 'sim/scenario/scenario.h', 'sim/files/atomic_file.h', 'sim/files/text.h',
                 'sim/result/limits.h', 'sim/tracking/tracking.h',
                 'sim/sensor_errors/faults.h'}  # its keys are in the cache's key


def includes(text):
    """Names of the #includes; '?' for a macro."""
    found = re.findall(r'^\s*#\s*include\s*(?:[<"](.+)[>"])?', text, re.MULTILINE)
    return [name or '?' for name in found]


def violations(file, text):
    """'file: included' for each include that the file's rule forbids; <vector> has neither folder nor ending."""
    rule = next((allowed for folder, allowed in RULES.items() if file.startswith(folder)), None)
    return [f'{file}: {name}' for name in includes(text) if rule is not None and ('..' in name or not (
        name.startswith(tuple(rule.split())) or re.fullmatch('[^./?]+', name)))]


def sources_below(*folders):
    return {str(file.relative_to(ROOT)): file.read_text() for folder in folders for file in (ROOT / folder).rglob('*')
            if file.suffix in ('.h', '.cc')}


def cycle(texts):
    """Units (X.h with X.cc) with circular dependencies."""
    needs = {}
    for file, text in texts.items():
        headers = {name.rpartition('.')[0] for name in includes(text) if name.endswith('.h')}
        unit = file.rpartition('.')[0]
        needs.setdefault(unit, set()).update(headers - {unit})
    try:
        graphlib.TopologicalSorter(needs).prepare()
    except graphlib.CycleError as error:
        return set(error.args[1])
    return set()


class IncludeRule(unittest.TestCase):
    def test_each_folder_sees_only_what_it_may(self):
        for folder in RULES:
            sources = sources_below(folder)
            self.assertTrue(sources, folder)
            self.assertEqual([], [each for file, text in sources.items() for each in violations(file, text)])
        self.assertLessEqual({f'sim/{folder.name}/' for folder in (ROOT / 'sim').iterdir() if folder.is_dir()}, set(RULES))

    def test_only_files_that_a_build_without_the_simulator_leaves_out_see_it(self):
        simulator = ('mujoco/', 'sim/physics/', 'sim/camera/', 'sim/room/', 'sim/live/')
        self.assertEqual({'tools/cli/gait_search.cc', 'tools/cli/gait_search.h', 'tools/cli/robot_command.cc', 'tools/cli/shared/live_world.cc'}, {file for file, text in sources_below('tools/cli').items()
                                                              if any(name.startswith(simulator) for name in includes(text))})

    def test_planted_violations_are_found(self):
        for file, name in (('slam/filter.cc', 'sim/physics/world.h'), ('slam/filter.cc', 'slam/../sim/physics/world.h'),
                           ('walking/plan.h', 'mujoco/mujoco.h'), ('sim/scenario/scenario.h', 'sim/physics/world.h'),
                           ('tools/cli/jobs/slurm.cc', 'sim/live/run.h')):
            self.assertEqual([f'{file}: {name}'], violations(file, f'  #  include\t<{name}>  // why\n'))
        self.assertEqual(['slam/filter.cc: ?'], violations('slam/filter.cc', '#include HEADER\n'))

    def test_no_two_files_need_each_other(self):
        sources = sources_below('walking', 'slam', 'sim', 'tools')
        self.assertGreater(len(sources), 200)
        self.assertEqual(set(), cycle(sources))
        self.assertEqual({'a/point', 'a/shape', 'a/text'},
                         cycle({'a/shape.h': '#include "a/point.h"\n', 'a/point.cc': '#include "a/text.h"\n',
                                'a/text.h': '#include "a/shape.h"\n', 'a/user.cc': '#include "a/shape.h"\n'}))


class FrontPage(unittest.TestCase):
    def test_is_one_page_and_shows_what_its_script_measured_last(self):
        stored, lines = json.loads(front_page.STORED.read_text()), (ROOT / 'README.md').read_text().splitlines()
        self.assertLessEqual(len(lines), 90)
        self.assertLessEqual(max(map(len, lines)), 100)
        for revision, differing in ((stored['revision'], 0), ('another', 1)):
            pages = front_page.pages(stored | {'revision': revision})
            self.assertEqual(differing, sum(path.read_text() != page for path, page in pages))

    def test_a_mean_has_its_interval_and_count(self):
        statistics = {'n': 10, 'mean': 3, 'sd': 1, 'median': 2, 'worst': 9}
        self.assertEqual('3.0 [2.3, 3.7], 10', front_page.cell('nees_position_mean', statistics, 1, '{:.1f}'))
        self.assertEqual('2.0 (9.0)', front_page.cell('rmse_m', statistics, 1, '{:.1f}'))

    def test_a_sample_that_differs_beyond_the_tolerance_is_named(self):
        stored = json.loads(front_page.STORED.read_text())['columns']
        self.assertEqual([], list(front_page.differences({'columns': stored}, stored)))
        for factor, named in ((1.1, 0), (2, 1)):
            now = json.loads(json.dumps(stored))
            now['slippery_laps']['plan_rmse_m']['sample'][0] *= factor
            self.assertEqual(named, len(list(front_page.differences({'columns': stored}, now))))
        self.assertGreater(len(list(front_page.differences({'columns': {}}, stored))), 30)


MODULES = ROOT / 'build/interop/node_modules'


@unittest.skipUnless(os.environ.get('CI') or (MODULES / 'eslint').exists(), 'tools/test.sh could not install eslint from npm')
class JavaScript(unittest.TestCase):
    def tool(self, script, config, *arguments, text=None):
        """The output of a tool from npm; empty if it has no complaint."""
        made = subprocess.run(['node', MODULES / script, '--config', ROOT / 'tests/interop' / config, *arguments], cwd=ROOT,
                              check=False, capture_output=True, text=True, input=text)
        return made.stdout + made.stderr if made.returncode else ''

    def test_is_laid_out_by_prettier_and_keeps_the_rules_of_eslint(self):
        scripts = ['sim/*/web/*.js', 'tests/**/*.cjs']
        self.assertEqual('', self.tool('prettier/bin/prettier.cjs', 'prettier.json', '--check', 'sim/*/web/*.css', *scripts))
        self.assertEqual('', self.tool('eslint/bin/eslint.js', 'eslint.config.cjs', '--max-warnings', '0', *scripts))

    def test_planted_violations_are_found(self):
        for text, rule in (('unknown();', 'no-undef'), ('let a = 1;\nconst b = a;', 'prefer-const')):
            self.assertIn(rule, self.tool('eslint/bin/eslint.js', 'eslint.config.cjs', '--stdin', '--stdin-filename', 'sim/view/web/x.js', text=text))

    def test_the_lock_file_names_no_registry(self):
        self.assertNotIn('"resolved"', (ROOT / 'tests/interop/package-lock.json').read_text())


class RecordingSources(unittest.TestCase):
    """Tests which source changes make recordings stale, using the hash computed by the build."""

    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.copy = pathlib.Path(place.name)
        shutil.copy(ROOT / 'README.md', self.copy)
        for folder in ('walking', 'slam', 'sim'):
            shutil.copytree(ROOT / folder, self.copy / folder)

    def hash(self):
        """Returns the generated source's line with the hash, or '' if the build step fails."""
        out = self.copy / 'revision.cc'
        made = subprocess.run([CMAKE, f'-DSOURCE={self.copy}', f'-DOUTPUT={out}', '-P', ROOT / 'tools/cli/revision.cmake'],
                              check=False, capture_output=True)
        return '' if made.returncode else re.search('kRecordingSources = .*', out.read_text())[0]

    def is_shaped_by(self, file):
        before = self.hash()
        with open(self.copy / file, 'a') as out:
            out.write('// changed\n')
        return self.hash() != before

    def test_are_those_of_walk_world_and_recording_and_not_those_of_filter_scores_and_pages(self):
        self.assertRegex(self.hash(), '"[0-9a-f]{16}')
        self.assertEqual(self.hash(), self.hash())
        for file in ('walking/footsteps.cc', 'walking/new.cc', 'sim/physics/world.cc', 'sim/camera/scene.cc', 'sim/room/paint.cc',
                     'sim/live/run.cc', 'sim/recording/recording_writer.cc', 'sim/sensor_errors/random.cc'):
            self.assertTrue(self.is_shaped_by(file), file)
        for file in ('README.md', 'slam/filter.cc', 'sim/regression/verdict.cc', 'sim/sensor_errors/image_errors.cc'):
            self.assertFalse(self.is_shaped_by(file), file)
        (self.copy / 'sim/live/setup.cc').unlink()
        self.assertEqual('', self.hash(), 'a missing source is an error of the build')

    def test_are_all_that_the_run_and_the_writer_include_but_what_is_named_here(self):
        units = ('live/run', 'live/self_check', 'live/frame_pipeline', 'live/steering_pose_buffer', 'live/setup')
        files = [f'sim/{unit}.{end}' for unit in units for end in ('h', 'cc')] + ['sim/recording/recording_writer.cc']
        files.remove('sim/live/self_check.cc')  # it reads the recording back
        included = {name for file in files for name in includes((ROOT / file).read_text()) if re.match(r'sim/.*\.h$', name)}
        self.assertGreater(len(included), 10)
        for header in included - SHAPE_NOTHING:
            self.assertTrue(self.is_shaped_by(header), f'{header}: a change leaves stale recordings')


if __name__ == '__main__':
    CMAKE = sys.argv.pop()
    unittest.main()
