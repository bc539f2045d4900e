#!/usr/bin/env python3
"""Replays one recorded walk under forty-two faults of its sensors and says how each run ended.

The recording is a result of `gaitslam run scenarios/tangent_circle.yaml`: results/tangent_circle/seed-1. No fault may crash the program, and a filter
that is far from the truth must say so: health other than ok, or an exit code other than 0."""
import json
import subprocess
import sys

import campaign

FRAMES = '{kind}: {{from_s: 12, duration_s: {s}{more}}}'


def listed(*faults):
    return ['errors.faults=[' + ', '.join('{' + fault + '}' for fault in faults) + ']']


def frames(kind, s, more=''):
    return listed(FRAMES.format(kind=kind, s=s, more=more))


FAULTS = {
    'none': [],
    **{f'frames lost for {s} s': frames('frames_lost', s) for s in (0.5, 2, 5, 25)},
    'all frames lost': listed('frames_lost: {from_s: 0, duration_s: 1000}'),
    **{f'frames frozen for {s} s': frames('frames_frozen', s) for s in (0.5, 2, 5, 25)},
    **{f'frames at {f} of their light for 5 s': frames('frames_dimmed', 5, f', factor: {f}') for f in (0.5, 0.1, 0.01, 0)},
    **{f'frames covered to {f} for 5 s': frames('frames_covered', 5, f', fraction: {f}') for f in (0.3, 0.6, 1)},
    **{f'{f} of frames doubled for 10 s': frames('frames_doubled', 10, f', fraction: {f}') for f in (0.2, 1)},
    **{f'{f} of frames reordered for 10 s': frames('frames_reordered', 10, f', fraction: {f}') for f in (0.2, 1)},
    'black camera': ['errors.image.gain=0'],
    'half the light': ['errors.image.gain=0.5'],
    'grey noise of 8': ['errors.image.read_sigma_grey=8'],
    'grey noise of 30': ['errors.image.read_sigma_grey=30'],
    'half of the frames lost': ['errors.image.loss_fraction=0.5'],
    'frames 0.1 s late': ['errors.image.latency_s=0.1'],
    'gyro silent for 5 s': listed('gyro_silent: {from_s: 12, duration_s: 5}'),
    'gyro silent': listed('gyro_silent: {from_s: 0, duration_s: 1000}'),
    **{f'gyro spike of {s} rad/s': listed(f'gyro_spike: {{from_s: 12, size_rad_s: {s}}}') for s in (1, 10, 1000)},
    'gyro noise of 0.1 rad/s': ['errors.gyro.sigma_rad_s=0.1'],
    'gyro bias of 0.05 rad/s': ['errors.gyro.bias_sigma_rad_s=0.05'],
    'gyro range of 0.3 rad/s': ['errors.gyro.range_rad_s=0.3'],
    'accelerometer silent': listed('accelerometer_silent: {from_s: 0, duration_s: 1000}'),
    'accelerometer spike of 100 m/s²': listed('accelerometer_spike: {from_s: 12, size_m_s2: 100}'),
    'plan missing for 5 s': listed('plan_missing: {from_s: 18, duration_s: 5}'),
    'plan missing': listed('plan_missing: {from_s: 0, duration_s: 1000}'),
    'plan 20 % too long': listed('plan_scaled: {from_s: 0, duration_s: 1000, factor: 1.2}'),
    'plan 20 % too short': listed('plan_scaled: {from_s: 0, duration_s: 1000, factor: 0.8}'),
    'gyro and frames lost for 5 s': listed('gyro_silent: {from_s: 12, duration_s: 5}', 'frames_lost: {from_s: 12, duration_s: 5}'),
    'sensors 20 ms apart': ['errors.motion.time_offset_s=0.02'],
}


def replay(args, name, number):
    out = args.out / f'{number:02}'
    ran = subprocess.run([args.program, 'replay', args.recording, *FAULTS[name], '--out', out, '--force'],
                         capture_output=True, text=True, check=False, timeout=600)
    found = next(out.rglob('score.json'), None)
    score = json.loads(found.read_text()) if found else {}
    metrics = {key: value['value'] for key, value in score.get('metrics', {}).items()}
    return {'exit_code': ran.returncode, 'ending': score.get('ending', 'no result'), 'metrics': metrics,
            'tracking': score.get('tracking'), 'stderr': ran.stderr[-300:]}


def main():
    parser = campaign.options(__doc__, len(FAULTS), 'faults, from the first on')
    parser.add_argument('recording', help='a result folder with its recording')
    args = parser.parse_args()
    journal = campaign.Journal(args.out)
    names = list(FAULTS)[:args.count]
    progress = campaign.Progress(len(names))
    for number, name in enumerate(names):
        if name not in journal:
            journal.add(name, **replay(args, name, number))
        progress.show(number + 1)
    rows = []
    for name in names:
        entry = journal.entries[name]
        rmse, share = (entry['metrics'].get(key) for key in ('rmse_m', 'tracked_fraction'))
        rows.append([name, entry['ending'], entry['exit_code'], '' if rmse is None else f'{1000 * rmse:.1f}',
                     '' if share is None else f'{100 * share:.0f}'])
    crashed = [row[0] for row in rows if row[2] not in (0, 1, 3)]
    campaign.write_table(args.out, ['fault', 'ending', 'exit code', 'rmse [mm]', 'tracked [%]'], rows,
                         f'{len(rows)} replays, {len(crashed)} without a result' + (': ' + ', '.join(crashed) if crashed else '') + '.')
    return 0 if not crashed else 1


if __name__ == '__main__':
    sys.exit(main())
