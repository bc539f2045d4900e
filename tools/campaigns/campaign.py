#!/usr/bin/env python3
"""Runs the program many times under kills, sensor faults or random walks and prints a table of what was lost.

    tools/campaigns/campaign.py kills --out DIR [--count N]
    tools/campaigns/campaign.py faults --out DIR [--count N] RESULT
    tools/campaigns/campaign.py walks --out DIR [--count N]

kills: sends SIGKILL at random moments of each command that writes, then runs the command again. A try is lost if a finished
result or a user file has other bytes or is gone, or if the rerun does not end as the command does without a kill.
faults: replays the recording of RESULT (`run scenarios/tangent_circle.yaml`) under faults of its sensors. A try is lost if
there is no result.
walks: walks random sequences of commands with the default gait, on a bare floor. A try is lost if the robot falls."""
import argparse
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def listed(*faults):
    return ['errors.faults=[' + ', '.join('{' + fault + '}' for fault in faults) + ']']


def during(kind, s, more='', begin=12):
    return f'{kind}: {{from_s: {begin}, duration_s: {s}{more}}}'


def always(kind, more=''):
    return listed(during(kind, 1000, more, 0))


def frames(kind, s, more=''):
    return listed(during(f'frames_{kind}', s, more))


FAULTS = {
    'none': [],
    **{f'frames lost for {s} s': frames('lost', s) for s in (0.5, 2, 5, 25)},
    'all frames lost': always('frames_lost'),
    **{f'frames frozen for {s} s': frames('frozen', s) for s in (0.5, 2, 5, 25)},
    **{f'frames at {f} of their light for 5 s': frames('dimmed', 5, f', factor: {f}') for f in (0.5, 0.1, 0.01, 0)},
    **{f'frames covered to {f} for 5 s': frames('covered', 5, f', fraction: {f}') for f in (0.3, 0.6, 1)},
    **{f'{f} of frames doubled for 10 s': frames('doubled', 10, f', fraction: {f}') for f in (0.2, 1)},
    **{f'{f} of frames reordered for 10 s': frames('reordered', 10, f', fraction: {f}') for f in (0.2, 1)},
    'black camera': ['errors.image.gain=0'],
    'half the light': ['errors.image.gain=0.5'],
    'gray noise of 8': ['errors.image.read_sigma_gray=8'],
    'gray noise of 30': ['errors.image.read_sigma_gray=30'],
    'half of the frames lost': ['errors.image.loss_fraction=0.5'],
    'frames 0.1 s late': ['errors.image.latency_s=0.1'],
    'gyro silent for 5 s': listed(during('gyro_silent', 5)),
    'gyro silent': always('gyro_silent'),
    **{f'gyro spike of {s} rad/s': listed(f'gyro_spike: {{from_s: 12, size_rad_s: {s}}}') for s in (1, 10, 1000)},
    'gyro noise of 0.1 rad/s': ['errors.gyro.sigma_rad_s=0.1'],
    'gyro bias of 0.05 rad/s': ['errors.gyro.bias_sigma_rad_s=0.05'],
    'gyro range of 0.3 rad/s': ['errors.gyro.range_rad_s=0.3'],
    'accelerometer silent': always('accelerometer_silent'),
    'accelerometer spike of 100 m/s²': listed('accelerometer_spike: {from_s: 12, size_m_s2: 100}'),
    'plan missing for 5 s': listed(during('plan_missing', 5, begin=18)),
    'plan missing': always('plan_missing'),
    'plan 20 % too long': always('plan_scaled', ', factor: 1.2'),
    'plan 20 % too short': always('plan_scaled', ', factor: 0.8'),
    'gyro and frames lost for 5 s': listed(during('gyro_silent', 5), during('frames_lost', 5)),
    'sensors 20 ms apart': ['errors.motion.time_offset_s=0.02'],
}

WALK = '''seed: 1
walk:
  commands:
    - stand: {{duration_s: 1}}
    - straight: {{forward_m: 0.1, left_m: 0}}
    - stand: {{duration_s: 0.5}}
camera: {{width_px: 64, height_px: 48, rate_hz: 15}}
slam: {{gyro: {{enabled: true}}, plan_velocity: {{enabled: true}}, height: {{enabled: true}}, vision: {{enabled: true}}}}
'''
SWEEP = 'scenario: walk.yaml\nseeds: 1..2\nparameters:\n  slam.gyro.sigma_rad_s: [0.01, 0.02]\n'
SUITE = 'seeds: 1..2\nscenarios:\n  - scenario: walk.yaml\n'
# Each leaves its output in out/.
COMMANDS = {
    'run': ['run', 'walk.yaml', '--out', 'out', '--force'],
    'run --seeds': ['run', 'walk.yaml', '--seeds', '1..3', '--jobs', '2', '--out', 'out', '--force'],
    'replay': ['replay', 'done/seed-1', '--out', 'out', '--force'],
    'record': ['record', 'walk.yaml', '--seeds', '1..2'],
    'sweep': ['sweep', 'sweep.yaml', '--jobs', '2', '--out', 'out'],
    'regress': ['regress', 'suite.yaml', '--baseline', 'baseline.json', '--out', 'out', '--force'],
    'export': ['export', 'done/seed-1', '--format', 'euroc', '--out', 'out', '--force'],
    'report': ['report', 'done/seed-1', '--out', 'out.html', '--force'],
    'report --plots': ['report', 'done/seed-1', '--plots', 'svg', '--out', 'out', '--force'],
}
VARYING = ('timing.csv', 'timing.json', 'junit.xml')


def write_table(folder, columns, rows, closing):
    lines = ['| ' + ' | '.join(columns) + ' |', '|' + '---|' * len(columns)]
    lines += ['| ' + ' | '.join(str(value) for value in row) + ' |' for row in rows]
    text = '\n'.join(lines) + '\n\n' + closing + '\n'
    folder.mkdir(parents=True, exist_ok=True)
    (folder / 'table.md').write_text(text)
    print(text)


def faults(args):
    rows = []
    for number, name in enumerate(list(FAULTS)[:args.count]):
        out = args.out / f'{number:02}'
        ran = subprocess.run([args.program, 'replay', args.result, *FAULTS[name], '--out', out, '--force'],
                             capture_output=True, text=True, check=False, timeout=600)
        found = next(out.rglob('score.json'), None)
        score = json.loads(found.read_text()) if found else {}
        rmse, share = (score.get('metrics', {}).get(key, {}).get('value') for key in ('rmse_m', 'tracked_fraction'))
        rows.append([name, score.get('ending', 'no result'), ran.returncode, '' if rmse is None else f'{1000 * rmse:.1f}',
                     '' if share is None else f'{100 * share:.0f}'])
    crashed = [row[0] for row in rows if row[2] not in (0, 1, 3)]
    write_table(args.out, ['fault', 'ending', 'exit code', 'rmse [mm]', 'tracked [%]'], rows,
                f'{len(rows)} replays, {len(crashed)} without a result' + ''.join('\n' + name for name in crashed))
    return 1 if crashed else 0


def digests(folder):
    """{path: hash} of the finished files below a folder that are the same in every run."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob('*')) if path.is_file() and path.name not in VARYING
            and not path.name.startswith('.') and 'cache' not in path.relative_to(folder).parts[:1]}


class Place:
    """A folder with user files, a finished result, and space for one output."""

    def __init__(self, args):
        self.args, self.folder = args, args.out / 'place'
        self.environment = {**os.environ, 'GAITSLAM_CACHE': str(self.folder / 'cache')}
        if not (self.folder / 'ready').exists():
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder.mkdir(parents=True)
            for name, text in {'walk.yaml': WALK.format(), 'sweep.yaml': SWEEP, 'suite.yaml': SUITE, 'notes.txt': 'user\'s own\n'}.items():
                (self.folder / name).write_text(text)
            self.must(['run', 'walk.yaml', '--out', 'done'])
            self.must(['baseline', 'update', 'suite.yaml', '--reason', 'a start', '--baseline', 'baseline.json', '--out', 'made'])
            (self.folder / 'ready').touch()

    def start(self, command):
        return subprocess.Popen([self.args.program, *command], cwd=self.folder, env=self.environment, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True, start_new_session=True)

    def call(self, command):
        process = self.start(command)
        return process.communicate()[1][-300:], process.returncode

    def must(self, command):
        complaint, code = self.call(command)
        if code > 1:
            raise SystemExit(f'{" ".join(command)}: {complaint}')
        return code

    def clear(self):
        for name in ('out', 'cache'):
            shutil.rmtree(self.folder / name, ignore_errors=True)
        (self.folder / 'out.html').unlink(missing_ok=True)


def try_once(place, command, reference, moment):
    """Kills the command at this fraction of its duration; returns what was lost, or an empty string. reference: exit code,
    digests and duration of the command that is not killed."""
    code, files, duration = reference
    place.clear()
    kept = digests(place.folder)
    process = place.start(command)
    time.sleep(moment * duration)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    try:
        while True:  # until no process of the group is left
            os.killpg(process.pid, 0)
            time.sleep(0.01)
    except ProcessLookupError:
        after = digests(place.folder)
    if any(after.get(name) != digest for name, digest in kept.items()):
        return 'an earlier file is gone or changed'
    complaint, again = place.call(command)
    if again != code:
        return f'exit code {again} instead of {code}: {complaint}'
    finished = digests(place.folder)
    differing = [name for name in files if finished.get(name) != files[name]]
    return f'other bytes: {", ".join(differing[:3])}' if differing else ''


def kills(args):
    args.out = args.out.resolve()
    place, references, random_moment = Place(args), {}, random.Random(1)
    tries = {kind: [] for kind in COMMANDS}  # what each lost
    for number in range(args.count):
        kind = list(COMMANDS)[number % len(COMMANDS)]
        if kind not in references:
            place.clear()
            start = time.monotonic()
            references[kind] = place.must(COMMANDS[kind]), digests(place.folder), time.monotonic() - start
        tries[kind].append(try_once(place, COMMANDS[kind], references[kind], random_moment.uniform(0, 1)))
    lost = [f'{kind}: {what}' for kind in COMMANDS for what in tries[kind] if what]
    write_table(args.out, ['command', 'kills', 'lost'], [[kind, len(all), sum(map(bool, all))] for kind, all in tries.items()],
                f'{args.count} kills, {len(lost)} lost' + ''.join('\n' + text for text in lost))
    return 1 if lost else 0


def random_commands(draw):
    """One to four commands of a walk on a bare floor."""
    far, angle = lambda most: round(draw.uniform(-most, most), 2), lambda: round(draw.choice((-1, 1)) * draw.uniform(5, 180), 1)
    radius = lambda: round(draw.uniform(0.2, 2), 2)
    kinds = (lambda: f'stand: {{duration_s: {draw.uniform(0, 2):.2f}}}',
             lambda: f'straight: {{forward_m: {far(2.5)}, left_m: {draw.choice((0, far(2.5)))}}}',
             lambda: f'straight: {{forward_m: 0, left_m: {far(2.5)}}}',
             lambda: f'tangent_arc: {{radius_m: {radius()}, angle_deg: {angle()}}}',
             lambda: f'perpendicular_arc: {{radius_m: {radius()}, angle_deg: {angle()}}}',
             lambda: f'turn: {{angle_deg: {angle()}, step_deg: {draw.uniform(1, 15):.1f}}}',
             lambda: f'go_to: {{x_m: {far(2)}, y_m: {far(2)}, heading_deg: {angle()}}}')
    return '[' + ', '.join('{' + draw.choice(kinds)() + '}' for _ in range(draw.randint(1, 4))) + ']'


def walks(args):
    draw, scenario, lost, rejected = random.Random(1), args.out / 'walk.yaml', [], 0
    args.out.mkdir(parents=True, exist_ok=True)
    scenario.write_text('world: {room: floor}\nwalk:\n  commands: [{stand: {duration_s: 1}}]\n')
    for number in range(1, args.count + 1):
        commands = random_commands(draw)
        ran = subprocess.run([args.program, 'run', scenario, f'walk.commands={commands}', f'seed={number}', '--out', args.out / 'run',
                              '--force', '-q'], capture_output=True, text=True, check=False, timeout=600)
        rejected += ran.returncode == 2
        if ran.returncode not in (0, 2):
            lost.append([number, commands, ran.returncode, ran.stderr[-300:].strip()])
    write_table(args.out, ['seed', 'commands', 'exit code', 'cause'], lost,
                f'{args.count} walks, {rejected} rejected before the walk, {len(lost)} lost')
    return 1 if lost else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    campaigns = parser.add_subparsers(required=True)
    for run, count in ((kills, 200), (faults, len(FAULTS)), (walks, 100)):
        campaign = campaigns.add_parser(run.__name__)
        campaign.set_defaults(run=run)
        campaign.add_argument('--count', type=int, default=count, help=f'number of tries (default {count})')
        campaign.add_argument('--out', type=pathlib.Path, required=True, help='folder of the campaign')
        campaign.add_argument('--program', type=pathlib.Path, default=ROOT / 'build/release/tools/cli/gaitslam')
        if run is faults:
            campaign.add_argument('result', help='a result folder with its recording')
    args = parser.parse_args()
    return args.run(args)


if __name__ == '__main__':
    sys.exit(main())
