#!/usr/bin/env python3
"""Table of the navigation of steered walks: true waist from the commanded path, walked by plan, truth and estimate.

Usage: tools/figures/navigation_table.py [--seeds 1..10] [--jobs 2] [--out DIR] [--by plan,truth,estimate] [SCENARIO...]
SCENARIO: names of scenarios/*.yaml, the steered ones unless given. Walks by plan and by truth need no camera.
GAITSLAM names another program than tools/gaitslam. Median and worst over the seeds, in mm and degrees.
"""
import argparse
import collections
import json
import os
import subprocess
import sys

SCENARIOS = ['perpendicular_circle_steered', 'perpendicular_circle_trial1_steered', 'straight_10m_steered',
             'tangent_circle_steered', 'tangent_laps_steered', 'tour_steered']
COLUMNS = [('end, mm', 'navigation_end_position_error_m', 1000), ('end, deg', 'navigation_end_yaw_error_deg', 1),
           ('rmse, mm', 'navigation_rmse_m', 1000), ('lap 1, mm', 'navigation_first_lap_end_error_m', 1000),
           ('last lap, mm', 'navigation_last_lap_end_error_m', 1000), ('largest step, mm', 'correction_largest_m', 1000),
           ('mean step, mm', 'correction_mean_m', 1000)]


def run(scenario, by, args):
    out = os.path.join(args.out, f'{scenario}_{by}')
    command = [os.environ.get('GAITSLAM', 'tools/gaitslam'), 'run', f'scenarios/{scenario}.yaml',
               f'walk.steering.by={by}', '--seeds', args.seeds, '--jobs', str(args.jobs), '--out', out, '--force']
    if by != 'estimate':
        command += ['--without', 'camera,slam']
    with open(out + '.log', 'w') as log:
        subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, check=False)
    with open(os.path.join(out, 'summary.json')) as file:
        return json.load(file)


def cell(metric, scale):
    if not metric or metric.get('median') is None:
        return '–'
    return f'{scale * metric["median"]:.1f} / {scale * metric["worst"]:.1f}'


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('scenarios', nargs='*', default=SCENARIOS)
    parser.add_argument('--seeds', default='1..10')
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--out', default='results/navigation_table')
    parser.add_argument('--by', default='plan,truth,estimate')
    args = parser.parse_args()
    os.makedirs(args.out, exist_ok=True)
    print('| scenario | by | ' + ' | '.join(title for title, _, _ in COLUMNS) + ' | endings |')
    print('|---|---|' + '---|' * (len(COLUMNS) + 1))
    for scenario in args.scenarios:
        for by in args.by.split(','):
            summary = run(scenario, by, args)
            cells = [cell(summary['metrics'].get(metric), scale) for _, metric, scale in COLUMNS]
            endings = collections.Counter(seed['ending'] for seed in summary['seeds'])
            ended = ', '.join(f'{n} {ending}' for ending, n in sorted(endings.items()))
            print(f'| {scenario} | {by} | ' + ' | '.join(cells) + f' | {ended} |')
            sys.stdout.flush()


if __name__ == '__main__':
    main()
