#!/usr/bin/env python3
"""Walks the four circles over five offices without camera and filter, and counts falls and collisions.

Each circle is walked with other seeds (mass, servos, push and floor as the scenario draws them) in each office."""
import json
import subprocess
import sys

import campaign

CIRCLES = ['tangent_circle', 'tangent_circle_paper', 'perpendicular_circle', 'perpendicular_circle_trial1']
OFFICES = range(1, 6)
AT_ONCE = 10  # seeds of one command


def walk(args, circle, office, first, last):
    """The ending of each seed's walk."""
    out = args.out / f'{circle}-{office}-{first}'
    scenario = campaign.ROOT / f'scenarios/{circle}.yaml'
    sections = [name for name in ('camera', 'slam') if f'{name}:' in config(args, scenario)]
    command = [args.program, 'run', scenario, f'world.seed={office}', '--seeds', f'{first}..{last}', '--jobs', str(args.jobs),
               '--out', out, '--force'] + (['--without', ','.join(sections)] if sections else [])
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    if ran.returncode not in (0, 1, 3):  # 1: a limit was missed; 3: a walk ended early
        sys.exit(f'walks: exit code {ran.returncode}: {ran.stderr}')
    endings = {}
    for seed in range(first, last + 1):
        about = out / f'seed-{seed}/about.json'
        endings[seed] = json.loads(about.read_text())['walk_ending'] if about.exists() else 'no result'
    return endings


def config(args, scenario):
    """The scenario's sections as `config` prints them, one `section:` for each."""
    ran = subprocess.run([args.program, 'config', scenario], capture_output=True, text=True, check=True)
    return {line.split('.')[0] + ':' for line in ran.stdout.splitlines()}


def main():
    parser = campaign.options(__doc__, 1000, 'walks')
    parser.add_argument('--jobs', type=int, default=2, help='walks at a time (default 2)')
    args = parser.parse_args()
    journal = campaign.Journal(args.out)
    each = args.count // (len(CIRCLES) * len(OFFICES))
    tasks = [(circle, office, first, min(first + AT_ONCE, each + 1) - 1)
             for first in range(1, each + 1, AT_ONCE) for circle in CIRCLES for office in OFFICES]
    progress = campaign.Progress(len(tasks))
    for done, task in enumerate(tasks, 1):
        name = '-'.join(map(str, task))
        if name not in journal:
            journal.add(name, circle=task[0], office=task[1], endings=walk(args, *task))
        progress.show(done)
    rows, lost = [], 0
    for circle in CIRCLES:
        for office in OFFICES:
            endings = [ending for entry in journal.entries.values() if entry['circle'] == circle and entry['office'] == office
                       for ending in entry['endings'].values()]
            others = sorted(set(endings) - {'completed'})
            rows.append([circle, office, len(endings), endings.count('completed'),
                         ', '.join(f'{endings.count(other)} {other}' for other in others) or 'none'])
            lost += len(endings) - endings.count('completed')
    tried = sum(row[2] for row in rows)
    campaign.write_table(args.out, ['circle', 'office', 'walks', 'completed', 'others'], rows,
                         f'{tried} walks, {lost} not completed.')
    return 0 if lost == 0 else 1


if __name__ == '__main__':
    sys.exit(main())
