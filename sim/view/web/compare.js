// Time series of the runs, the figures that show them, and the marks where two runs start to differ.
import {drawn} from '../../pages/web/figures.js';
import {lastUpTo} from './run.js';
import {withLength} from './source.js';

const kSensors = ['vision', 'gyro', 'plan_velocity', 'height'],
  kHalf_s = 0.5;

/// The values of a run's frames as columns, in chronological order; NaN: unknown. The names are defined by
/// Series in site.h.
export class Series {
  constructor(names, columns) {
    this.names = names;
    names.forEach((name, i) => {
      this[name] = columns?.[i] ?? [];
    });
    this.derive();
  }

  /// Reads the program's format: the names, then the columns as float32.
  static of(buffer) {
    const [names, begin] = withLength(buffer),
      rows = (buffer.byteLength - begin) / 4 / names.length;
    return new Series(
      names,
      names.map((_, i) => new Float32Array(buffer, begin + 4 * rows * i, rows))
    );
  }

  add(from, rows) {
    rows.forEach((row, i) =>
      row.forEach((value, k) => {
        this[this.names[k]][from + i] = value ?? NaN;
      })
    );
    this.derive();
  }

  derive() {
    this.distance = this.x.map((_, i) => Math.hypot(this.x[i], this.y[i], this.z[i]));
    for (const name of kSensors) this[`mean_nis_${name}`] = this.smoothed(this[`nis_${name}`]);
  }

  /// The mean of the known values within half a second before and after.
  smoothed(values) {
    let from = 0,
      to = 0,
      sum = 0,
      count = 0;
    const add = (i, sign) => {
      if (Number.isFinite(values[i])) {
        sum += sign * values[i];
        count += sign;
      }
    };
    return Array.from(this.t, (t) => {
      for (; to < values.length && this.t[to] <= t + kHalf_s; ++to) add(to, 1);
      for (; this.t[from] < t - kHalf_s; ++from) add(from, -1);
      return count ? sum / count : NaN;
    });
  }

  /// The row nearest to a time; past the last row, an index without a row.
  at(t) {
    const row = Math.max(
      0,
      lastUpTo(t, this.t.length, (i) => this.t[i])
    );
    return t > this.t[row] && !(this.t[row + 1] - t > t - this.t[row]) ? row + 1 : row;
  }
}

const rowsOf = (a, b) => Array.from(b.t, (t) => a.at(t));

const kFigures = [
  {name: 'error_x', title: 'Error in x, 3σ [mm]', parts: [['', 'x']], sigma: 'sigma_x'},
  {name: 'error_y', title: 'Error in y, 3σ [mm]', parts: [['', 'y']], sigma: 'sigma_y'},
  {name: 'error_z', title: 'Error in z, 3σ [mm]', parts: [['', 'z']], sigma: 'sigma_z'},
  {name: 'heading', title: 'Heading error, 3σ [deg]', parts: [['', 'heading']], sigma: 'sigma_heading'},
  {
    name: 'nees',
    title: 'NEES of the position (3 expected, 95 % below 7.8)',
    parts: [['', 'nees']],
    levels: [3, 7.81],
    zero: true
  },
  ...kSensors.map((sensor) => ({
    name: `nis_${sensor}`,
    title: `NIS per degree of freedom of ${sensor}, mean over 1 s (1 expected)`,
    parts: [['', `mean_nis_${sensor}`]],
    levels: [1],
    zero: true,
    onDemand: true
  })),
  {
    name: 'landmarks',
    title: 'Landmarks',
    parts: [
      ['found', 'found'],
      ['in the map', 'landmarks']
    ],
    zero: true
  },
  {
    name: 'slip',
    title: 'Slip of the standing soles [mm]',
    parts: [
      ['left', 'slip_left'],
      ['right', 'slip_right']
    ],
    zero: true,
    onDemand: true
  },
  {
    name: 'margin',
    title: 'ZMP: distance inside the support polygon [mm]',
    parts: [['', 'margin']],
    zero: true,
    onDemand: true
  }
];
/// The names of the figures that are drawn only on request.
export const kOnDemand = kFigures.filter(({onDemand}) => onDemand).map(({name}) => name);

const isKnown = (column) => column.some(Number.isFinite);
const full = (name, part) => [name, part].filter(Boolean).join(', ') || 'value';

/// The names of the figures that have at least one value, in order.
export const known = (runs) =>
  kFigures
    .filter(({parts}) => parts.some(([, key]) => runs.some(({series}) => isKnown(series[key]))))
    .map(({name}) => name);

/// The figures that have at least one value and are not hidden. runs: {name, role, series}. marks: [{t,
/// text}].
export function figures(runs, marks, hidden) {
  return kFigures
    .filter(({name}) => !hidden.has(name))
    .flatMap(({name, title, parts, sigma, levels, zero}) => {
      const lines = runs
        .flatMap(({name: run, role, series}) =>
          parts.map(([part, key], i) => ({
            name: full(run, part),
            role: i > 0 && runs.length === 1 ? 'plan' : role,
            thin: i > 0,
            x: series.t,
            y: series[key]
          }))
        )
        .filter(({y}) => isKnown(y));
      const bands = sigma
        ? runs
            .filter(({series}) => isKnown(series[sigma]))
            .map(({name: run, role, series}) => ({
              name: full(run, '3σ'),
              role,
              x: series.t,
              low: series[sigma].map((s) => -3 * s),
              high: series[sigma].map((s) => 3 * s)
            }))
        : [];
      return lines.length ? [drawn({name, title, lines, bands, levels, zero, marks})] : [];
    });
}

/// The distance of each estimate from the truth and, for several runs, the second run's distance minus the
/// first's. Null without errors.
export function timeLine(runs, marks, width) {
  const lines = runs
    .map(({name, role, series}) => ({name: full(name, 'error'), role, x: series.t, y: series.distance}))
    .filter(({y}) => isKnown(y));
  if (!lines.length) return null;
  const spec = {
    name: 'distance',
    title: 'Distance of the estimate from the truth [mm]',
    lines,
    marks,
    zero: true,
    width,
    height: 128
  };
  if (lines.length < 2) return drawn(spec);
  const [a, b] = runs,
    distance = rowsOf(a.series, b.series).map((row, i) => b.series.distance[i] - a.series.distance[row]),
    zeros = distance.map(() => 0),
    x = b.series.t;
  return drawn({
    ...spec,
    title: `Distance of each estimate from the truth; filled: ${b.name} minus ${a.name} [mm]`,
    lines: [...lines, {name: 'difference', role: 'truth', thin: true, x, y: distance}],
    bands: [
      {role: b.role, x, low: zeros, high: distance.map((d) => Math.max(d, 0))},
      {role: a.role, x, low: distance.map((d) => Math.min(d, 0)), high: zeros}
    ]
  });
}

const kLongest_s = 1,
  kSame_m = 1e-6,
  kSamePlace_m = 0.1;
const outcomes = (frame) => new Map((frame.searches ?? []).map((search) => [search[0], search[6]]));
const between = (p, q) => Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);

/// Landmarks of two maps that are nearest to each other and within 0.1 m, as a map from the number in a to
/// the number in b. Landmark numbers of different runs are unrelated.
export function matched(a, b) {
  const nearest = ([, p], others) =>
    others.reduce(
      (best, other) => (between(p, other[1]) < (best ? between(p, best[1]) : kSamePlace_m) ? other : best),
      null
    );
  return new Map(
    a.flatMap((one) => {
      const other = nearest(one, b);
      return other && nearest(other, a)[0] === one[0] ? [[one[0], other[0]]] : [];
    })
  );
}
const apart = (p, q) => p && q && between(p, q) > kSame_m;

/// The times at which the second run starts to differ: [{t, kind, text}]. Landmarks and estimates are
/// compared if both used one recording.
export function partings([a, b]) {
  const found = [],
    rows = rowsOf(a.series, b.series);
  let since = null;
  for (let i = 0; i < rows.length; ++i) {
    const differs = ['x', 'y', 'z', 'heading'].some(
      (axis) => Math.abs(b.series[axis][i] - a.series[axis][rows[i]]) > 3 * a.series[`sigma_${axis}`][rows[i]]
    );
    since = differs ? (since ?? b.series.t[i]) : null;
    if (since === null || b.series.t[i] - since < kLongest_s) continue;
    found.push({
      t: since,
      kind: 'parting',
      text: `errors differ by more than 3σ of ${a.name} along an axis or in heading for ${kLongest_s} s`
    });
    break;
  }
  if (!a.run.about.recording || a.run.about.recording !== b.run.about.recording) return found;
  const pairs = b.run.frames
    .map((frame) => [a.run.frames[a.run.indexAt(frame.t)], frame])
    .filter(([first]) => first);
  const first = (text, differs) => {
    const pair = pairs.find(differs);
    if (pair) found.push({t: pair[1].t, kind: 'parting', text});
  };
  first('first difference between the estimates', ([p, q]) => apart(p.estimate, q.estimate));
  const mapOf = ({run}, {t}) => run.mapAt(run.indexAt(t));
  first('first search with a different outcome', ([p, q]) => {
    const [of, other] = [outcomes(p), outcomes(q)];
    return [...matched(mapOf(a, p), mapOf(b, q))].some(
      ([id, same]) => of.has(id) && other.has(same) && of.get(id) !== other.get(same)
    );
  });
  return found;
}
