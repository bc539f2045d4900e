#!/usr/bin/env python3
"""Kills the program with SIGKILL at random moments of every command that writes, then runs the same command again.

Lost is a try after which a finished result or a file of the user's has other bytes or is gone, or after which the same
command does not end as it does when nothing kills it."""
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time

import campaign

WALK = '''seed: 1
walk:
  commands:
    - stand: {{duration_s: 1}}
    - straight: {{forward_m: 0.1, left_m: 0}}
    - stand: {{duration_s: 0.5}}
camera: {{width_px: 64, height_px: 48, rate_hz: 15}}
slam: {{gyro: {{enabled: true}}, plan_velocity: {{enabled: true}}, height: {{enabled: true}}, vision: {{enabled: true}}}}
'''
SWEEP = 'scenario: walk.yaml\nseeds: 1..2\ngrid:\n  slam.gyro.sigma_rad_s: [0.01, 0.02]\n'
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


def digests(folder):
    """Bytes of the finished files below a folder; what varies from run to run is left out."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob('*')) if path.is_file() and path.name not in VARYING
            and not path.name.startswith('.') and 'cache' not in path.relative_to(folder).parts[:1]}


class Place:
    """A folder with a user's files, a finished result, and room for one output."""

    def __init__(self, args):
        self.args, self.folder = args, args.out / 'place'
        self.environment = {**os.environ, 'GAITSLAM_CACHE': str(self.folder / 'cache')}
        if not (self.folder / 'ready').exists():
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder.mkdir(parents=True)
            for name, text in {'walk.yaml': WALK.format(), 'sweep.yaml': SWEEP, 'suite.yaml': SUITE, 'notes.txt': 'of the user\n'}.items():
                (self.folder / name).write_text(text)
            self.must(['run', 'walk.yaml', '--out', 'done'])
            self.must(['baseline', 'update', 'suite.yaml', '--reason', 'a start', '--baseline', 'baseline.json', '--out', 'made'])
            (self.folder / 'ready').touch()

    def start(self, command):
        return subprocess.Popen([self.args.program, *command], cwd=self.folder, env=self.environment, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True, start_new_session=True)

    def call(self, command):
        process = self.start(command)
        complaint = process.communicate()[1]
        return process.returncode, complaint[-300:]

    def must(self, command):
        code, complaint = self.call(command)
        if code > 1:
            raise SystemExit(f'{" ".join(command)}: {complaint}')
        return code

    def clear(self):
        shutil.rmtree(self.folder / 'out', ignore_errors=True)
        shutil.rmtree(self.folder / 'cache', ignore_errors=True)
        (self.folder / 'out.html').unlink(missing_ok=True)


def undisturbed(place, command):
    """Exit code, output and duration of a command that nothing kills."""
    place.clear()
    begin = time.monotonic()
    code = place.must(command)
    return code, digests(place.folder), time.monotonic() - begin


def wait_for_end(group):
    """Until no process of the group is left: a killed one takes a while to give back its memory."""
    try:
        while True:
            os.killpg(group, 0)
            time.sleep(0.01)
    except ProcessLookupError:
        pass


def try_once(place, command, reference, moment):
    """What was lost by a kill at this part of the command's duration; empty if nothing."""
    code, files, duration = reference
    place.clear()
    kept = digests(place.folder)
    process = place.start(command)
    time.sleep(moment * duration)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    wait_for_end(process.pid)
    after = digests(place.folder)
    if any(after.get(name) != digest for name, digest in kept.items()):
        return 'a file from before is gone or changed'
    again, complaint = place.call(command)
    if again != code:
        return f'exit code {again} instead of {code}: {complaint}'
    finished = digests(place.folder)
    differing = [name for name in files if finished.get(name) != files[name]]
    return f'other bytes: {", ".join(differing[:3])}' if differing else ''


def main():
    args = campaign.options(__doc__, 200, 'kills').parse_args()
    args.out = args.out.resolve()
    journal, place = campaign.Journal(args.out), Place(args)
    random_moment = random.Random(1)
    references, progress = {}, campaign.Progress(args.count)
    for number in range(args.count):
        kind = list(COMMANDS)[number % len(COMMANDS)]
        moment, name = random_moment.uniform(0, 1), f'{number}'
        if name not in journal:
            if kind not in references:
                references[kind] = undisturbed(place, COMMANDS[kind])
            journal.add(name, command=kind, moment=moment, lost=try_once(place, COMMANDS[kind], references[kind], moment))
        progress.show(number + 1)
    rows, lost = [], []
    for kind in COMMANDS:
        entries = [entry for entry in journal.entries.values() if entry['command'] == kind]
        wrong = [entry['lost'] for entry in entries if entry['lost']]
        rows.append([kind, len(entries), len(wrong)])
        lost += [f'{kind}: {text}' for text in wrong]
    campaign.write_table(args.out, ['command', 'kills', 'lost'], rows,
                         f'{len(journal.entries)} kills, {len(lost)} lost.' + ''.join('\n' + text for text in lost))
    return 0 if not lost else 1


if __name__ == '__main__':
    sys.exit(main())
