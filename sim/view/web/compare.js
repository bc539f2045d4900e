// Time series of the runs, the figures that show them, and the marks where two runs start to differ.
import {Quaternion, Vector3} from 'three/build/three.module.js';
import {drawn, lastUpTo} from '../../pages/web/figures.js';
import {between} from './run.js';
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

  /// Adds what arrives with the frames of a finished run.
  addFeet(frames) {
    frames.forEach(({feet, margin}, i) => {
      this.slip_left[i] = feet?.[0].slip ?? NaN;
      this.slip_right[i] = feet?.[1].slip ?? NaN;
      this.margin[i] = margin ?? NaN;
    });
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

const errorOf = (name, axis, title) => ({name, title, parts: {'': axis}, sigma: `sigma_${axis}`});
const kFigures = [
  ...['x', 'y', 'z'].map((axis) => errorOf(`error_${axis}`, axis, `Error in ${axis}, 3σ [mm]`)),
  errorOf('heading', 'heading', 'Heading error, 3σ [deg]'),
  {
    name: 'nees',
    title: 'NEES of the position (3 expected, 95 % below 7.8)',
    parts: {'': 'nees'},
    levels: [3, 7.81]
  },
  ...kSensors.map((sensor) => ({
    name: `nis_${sensor}`,
    title: `NIS per degree of freedom of ${sensor}, mean over 1 s (1 expected)`,
    parts: {'': `mean_nis_${sensor}`},
    levels: [1],
    onDemand: true
  })),
  {name: 'landmarks', title: 'Landmarks', parts: {found: 'found', 'in the map': 'landmarks'}},
  {
    name: 'slip',
    title: 'Slip of the standing soles [mm]',
    parts: {left: 'slip_left', right: 'slip_right'},
    onDemand: true
  },
  {
    name: 'margin',
    title: 'ZMP: distance inside the support polygon [mm]',
    parts: {'': 'margin'},
    onDemand: true
  }
];
/// The names of the figures that are drawn only on request.
export const kOnDemand = [...kFigures.filter(({onDemand}) => onDemand).map(({name}) => name), 'rpe'];

/// The dashes of a run's lines, so that they can be distinguished without colors, and identical ones are
/// both visible.
const kDashes = {second: '7 4', third: '2 3', first: '9 3 2 3'};
const dashOf = (role) => kDashes[role];

const kLengths_m = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20],
  kEvery = 3; // frames between the starts of segments

/// The RMS error of the displacement over segments of the true path, by their length: x (m), y (mm).
export function relativeErrors(frames) {
  const poses = frames.filter(({truth, estimate}) => truth && estimate),
    lengths = [0];
  for (let i = 1; i < poses.length; ++i)
    lengths.push(lengths[i - 1] + between(poses[i].truth, poses[i - 1].truth));
  /// The displacement in the axes of the first pose.
  const moved = (name, i, j) => {
    const [, , , ...turn] = poses[i][name];
    return new Vector3(...poses[j][name])
      .sub(new Vector3(...poses[i][name]))
      .applyQuaternion(new Quaternion(...turn).inverse());
  };
  const rms = (length) => {
    let sum = 0,
      count = 0;
    for (let i = 0; i < poses.length; i += kEvery) {
      const j = 1 + lastUpTo(lengths[i] + length, lengths.length, (k) => lengths[k]);
      if (j >= poses.length) break;
      sum += moved('truth', i, j).distanceToSquared(moved('estimate', i, j));
      ++count;
    }
    return 1e3 * Math.sqrt(sum / count);
  };
  const x = kLengths_m.filter((length) => length < lengths.at(-1));
  return {x, y: x.map(rms)};
}

const isKnown = (column) => column.some(Number.isFinite);
const full = (name, part) => [name, part].filter(Boolean).join(', ') || 'value';

/// The names of the figures that have at least one value, in order.
export const known = (runs) => [
  ...kFigures
    .filter(({parts}) => Object.values(parts).some((key) => runs.some(({series}) => isKnown(series[key]))))
    .map(({name}) => name),
  ...(runs.some(({series}) => isKnown(series.x)) ? ['rpe'] : [])
];

/// The relative error over the length of the path.
const rpeOf = (panes) =>
  drawn({
    name: 'rpe',
    title: 'Relative position error over the length of a segment [m], RMS [mm]',
    lines: panes.map(({name, role, run}) => ({
      name: name || 'RMS',
      role,
      dash: dashOf(role),
      ...relativeErrors(run.frames)
    })),
    overTime: false,
    zero: true
  });

/// The figures that have at least one value and are not hidden. runs: {name, role, series}. marks: [{t,
/// text}].
export function figures(runs, marks, hidden) {
  const shown = kFigures
    .filter(({name}) => !hidden.has(name))
    .flatMap(({name, title, parts, sigma, levels}) => {
      const lines = runs
        .flatMap(({name: run, role, series}) =>
          Object.entries(parts).map(([part, key], i) => ({
            name: full(run, part),
            role: i > 0 && runs.length === 1 ? 'plan' : role,
            dash: dashOf(role),
            thin: i > 0,
            x: series.t,
            y: series[key],
            isOff: series.health
          }))
        )
        .filter(({y}) => isKnown(y));
      const bands = sigma
        ? runs
            .filter(({series}) => isKnown(series[sigma]))
            .map(({name: run, role, series}) => ({
              name: full(run, '3σ'),
              role,
              starts: series === runs[0].series,
              x: series.t,
              low: series[sigma].map((s) => -3 * s),
              high: series[sigma].map((s) => 3 * s)
            }))
        : [];
      return lines.length ? [drawn({name, title, lines, bands, levels, zero: !sigma, marks})] : [];
    });
  return hidden.has('rpe') ? shown : [...shown, rpeOf(runs)];
}

/// The distance of each estimate from the truth and, for several runs, the second run's distance minus the
/// first's. Null without errors.
export function timeLine(runs, marks, width) {
  const lines = runs
    .map(({name, role, series}) => ({
      name: full(name, 'error'),
      role,
      dash: dashOf(role),
      x: series.t,
      y: series.distance,
      isOff: series.health
    }))
    .filter(({y}) => isKnown(y));
  if (!lines.length) return null;
  const spec = {
    name: 'distance',
    title: `Distance of the estimate from the truth${lines.some(({isOff}) => isOff.some((v) => v > 0)) ? '; dotted: lost' : ''} [mm]`,
    lines,
    marks,
    zero: true,
    width,
    height: 112
  };
  if (lines.length < 2) return drawn(spec);
  const [a, b] = runs,
    rows = rowsOf(a.series, b.series),
    distance = rows.map((row, i) => b.series.distance[i] - a.series.distance[row]),
    isOff = rows.map((row, i) => Math.max(a.series.health[row], b.series.health[i])),
    zeros = distance.map(() => 0),
    x = b.series.t;
  return drawn({
    ...spec,
    title: `Distance of each estimate from the truth; dotted: lost; filled: ${b.name} minus ${a.name} [mm]`,
    lines: [...lines, {name: 'difference', role: 'truth', thin: true, x, y: distance, isOff}],
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
const smaller = (...sigmas) => Math.min(...sigmas.filter(Number.isFinite));
const apart = (p, q) => p && q && between(p, q) > kSame_m;

/// The time from which the errors of two runs differ by more than 3 of the smaller standard deviations along
/// an axis or in heading for a second, or undefined.
function divergence(a, b) {
  const [p, q] = a.t.length <= b.t.length ? [a, b] : [b, a],
    rows = rowsOf(q, p);
  let since = null;
  for (let i = 0; i < rows.length; ++i) {
    const differs = ['x', 'y', 'z', 'heading'].some((axis) => {
      const sigma = smaller(p[`sigma_${axis}`][i], q[`sigma_${axis}`][rows[i]]);
      return Math.abs(p[axis][i] - q[axis][rows[i]]) > 3 * sigma;
    });
    since = differs ? (since ?? p.t[i]) : null;
    if (since !== null && p.t[i] - since >= kLongest_s) return since;
  }
  return undefined;
}

/// The times at which the second run starts to differ: [{t, kind, text, pair}]. Landmarks and estimates are
/// compared if both used one recording. pair: the search that differs: {ids, outcomes} of both.
export function partings([a, b]) {
  const found = [],
    since = divergence(a.series, b.series);
  if (since !== undefined)
    found.push({
      t: since,
      kind: 'parting',
      name: 'sigma',
      text: `errors differ by more than 3σ (the smaller one) along an axis or in heading for ${kLongest_s} s`
    });
  if (!a.run.about.recording || a.run.about.recording !== b.run.about.recording) return found;
  const pairs = b.run.frames
    .map((frame) => [a.run.frames[a.run.indexAt(frame.t)], frame])
    .filter(([first]) => first);
  const first = (name, text, differs) => {
    const pair = pairs.find(differs);
    if (pair) found.push({t: pair[1].t, kind: 'parting', name, text});
    return pair;
  };
  first('estimate', 'first difference between the estimates', ([p, q]) => apart(p.estimate, q.estimate));
  const mapOf = ({run}, {t}) => run.mapAt(run.indexAt(t));
  const differing = ([p, q]) => {
    const [of, other] = [outcomes(p), outcomes(q)];
    return [...matched(mapOf(a, p), mapOf(b, q))].find(
      ([id, same]) => of.has(id) && other.has(same) && of.get(id) !== other.get(same)
    );
  };
  const pair = first('search', 'first search with a different outcome', differing);
  if (pair) {
    const ids = differing(pair);
    Object.assign(found.at(-1), {ids, outcomes: ids.map((id, i) => outcomes(pair[i]).get(id))});
  }
  return found;
}

/// The RMS errors (mm) of two runs while both track.
function commonErrors(a, b) {
  const rows = rowsOf(a, b),
    sums = [0, 0];
  let count = 0;
  rows.forEach((row, i) => {
    if (a.health[row] !== 0 || b.health[i] !== 0 || !Number.isFinite(a.distance[row] + b.distance[i])) return;
    sums[0] += a.distance[row] ** 2;
    sums[1] += b.distance[i] ** 2;
    ++count;
  });
  return sums.map((sum) => Math.sqrt(sum / count));
}

/// States why one of the first two runs is worse: {text, t}, or null if they do not part.
export function whyWorse([a, b], marks) {
  const errors = commonErrors(a.series, b.series),
    worse = Number(errors[1] > errors[0]),
    {sigma, search, estimate} = Object.fromEntries(marks.map((mark) => [mark.name, mark]));
  if (errors[0] === errors[1] || !(sigma ?? search ?? estimate)) return null;
  const bad = [a, b][worse],
    good = [b, a][worse],
    {t} = sigma ?? search ?? estimate,
    flags = bad.run.about.moments.filter(
      ({kind, t: at}) => ['lost', 'suspect', 'fault'].includes(kind) && at <= t
    );
  const parts = [
    !search && estimate && `the estimates differ from ${estimate.t.toFixed(2)} s`,
    search &&
      `at ${search.t.toFixed(2)} s landmark ${search.ids[worse]} was ${search.outcomes[worse]} ` +
        `(${good.name}: landmark ${search.ids[1 - worse]}, ${search.outcomes[1 - worse]})`,
    sigma ? `from ${sigma.t.toFixed(2)} s the errors differ by more than 3σ` : 'the errors stay within 3σ',
    flags.length
      ? `known by then: ${flags.map(({t: at, text}) => `${text} (${at.toFixed(2)} s)`).join(', ')}`
      : 'nothing was flagged by then'
  ];
  const [more, less] = [errors[worse], errors[1 - worse]].map((error) => error.toPrecision(3));
  const title = `Why ${bad.name} is worse (RMS error ${more} mm, ${good.name} ${less} mm)`;
  return {text: `${title}: ${parts.filter(Boolean).join('; ')}.`, t};
}
