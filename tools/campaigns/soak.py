#!/usr/bin/env python3
"""Walks for a long simulated time with camera and filter and watches the memory of the process.

Prints the resident memory at parts of the walk: what grows from the half to the end is growth, not warming up."""
import pathlib
import subprocess
import sys
import time

import campaign

ROUND_S = 33.0  # the tangent circle's four quarters and pauses, about


def scenario_text(minutes):
    rounds = max(1, round(60 * minutes / ROUND_S))
    quarter = '    - stand: {duration_s: 1}\n    - tangent_arc: {radius_m: 0.75, angle_deg: 90}\n'
    walk = '    - stand: {duration_s: 1}\n    - straight: {forward_m: 1.0, left_m: -0.5}\n' + 4 * rounds * quarter
    return f'base: {campaign.ROOT}/scenarios/tangent_circle.yaml\n\nwalk:\n  commands:\n{walk}    - stand: {{duration_s: 1}}\n'


def walk_s(program, scenario):
    """The duration of the walk, as `check` says it."""
    said = subprocess.run([program, 'check', scenario], capture_output=True, text=True, check=True).stdout
    return float(said.split('a walk of ')[1].split()[0])


def resident_mib(pid):
    status = pathlib.Path(f'/proc/{pid}/status').read_text()
    return next(int(line.split()[1]) / 1024 for line in status.splitlines() if line.startswith('VmRSS'))


def main():
    parser = campaign.options(__doc__, 20, 'simulated minutes')
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    scenario = args.out / 'soak.yaml'
    scenario.write_text(scenario_text(args.count))
    samples, begin = [], time.monotonic()
    with open(args.out / 'said.txt', 'w') as said:
        process = subprocess.Popen([args.program, 'run', scenario, '--out', args.out / 'result', '--force'], stdout=said, stderr=said)
        while process.poll() is None:
            try:
                samples.append((time.monotonic() - begin, resident_mib(process.pid)))
            except (OSError, StopIteration):
                break  # it ends just now
            time.sleep(1)
    code = process.wait()
    wall = time.monotonic() - begin
    rows = []
    for part in (0.1, 0.25, 0.5, 0.75, 0.95):
        at = min(samples, key=lambda sample: abs(sample[0] - part * wall))
        rows.append([f'{100 * part:.0f} %', f'{at[1]:.0f}'])
    grown = float(rows[-1][1]) - float(rows[2][1])
    campaign.write_table(args.out, ['part of the walk', 'resident [MiB]'], rows,
                         f'{walk_s(args.program, scenario) / 60:.1f} simulated minutes in {wall / 60:.1f} min, exit code {code}, '
                         f'{grown:.0f} MiB more at 95 % than at 50 %.')
    return code


if __name__ == '__main__':
    sys.exit(main())
