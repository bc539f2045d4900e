// A run in the page: its frames, and quantities derived from consecutive frames.
//
// A frame: t (s); truth, plan, estimate: poses of the camera [x, y, z, qx, qy, qz, qw]; bodies: such poses of
// the robot's bodies, one after another; ellipsoid: rows of the matrix that maps the unit sphere to the
// 3-sigma ellipsoid of the estimated position; landmarks: their number; health (0 ok, 1 lost, 2 diverged) and
// state in words; searches: [landmark, u, v, half axes of the ellipse, its angle, outcome, u and v of the
// match]; source: number of the stored image that the filter got; new: [u, v, landmark] of new landmarks;
// ended: landmarks that left the map; map: [landmark, position, ellipsoid, begin] if known; feet (left,
// right): plan [x, y, heading], planned_down, landed [x, y, heading] while loaded; support: corners of the
// support polygon; zmp; rig: number for fetching the rig's readings. m, rad, px.

import {lastUpTo} from '../../pages/web/figures.js';

/// The outcomes of a search differ in color and shape: an ellipse with a square, a dashed ellipse, an ellipse
/// with a cross.
export const kOutcomes = {found: '#3ddc63', missed: '#ffd228', rejected: '#ff5cc8'};

/// The corners of a sole at [x, y, heading].
export function soleCorners(sole, [x, y, heading]) {
  const [x0, y0, x1, y1] = sole,
    c = Math.cos(heading),
    s = Math.sin(heading);
  return [
    [x0, y0],
    [x1, y0],
    [x1, y1],
    [x0, y1]
  ].map(([a, b]) => [x + c * a - s * b, y + s * a + c * b]);
}

/// The distance of two positions, which may have more elements.
export const between = ([x, y, z], [a, b, c]) => Math.hypot(x - a, y - b, z - c);

export class Run {
  constructor(about, index) {
    Object.assign(this, {
      about,
      index,
      frames: [],
      maps: [],
      begins: new Map(),
      ends: new Map(),
      landed: [],
      planned: [],
      last: [null, null],
      plannedDown: [false, false]
    });
  }

  /// The run's camera; one of standard size if the run has no images.
  get camera() {
    return this.about.camera ?? {width: 320, height: 240, fu: 160, fv: 160, u0: 160, v0: 120};
  }

  get duration() {
    return this.frames.length ? this.frames.at(-1).t : this.about.duration;
  }

  append(frame) {
    if (this.frames.length && frame.t <= this.frames.at(-1).t) return false;
    if (frame.map) this.maps.push(this.frames.length);
    for (const [, , id] of frame.new ?? []) this.begins.set(id, frame.t);
    for (const id of frame.ended ?? []) this.ends.set(id, frame.t);
    for (const [id, , , begin] of frame.map ?? []) if (!this.begins.has(id)) this.begins.set(id, begin);
    frame.feet?.forEach((foot, i) => this.addFootprints(frame.t, foot, i));
    this.frames.push(frame);
    return true;
  }

  addFootprints(t, foot, i) {
    const {sole} = this.about;
    if (!sole) return;
    const landed = foot.landed && String(foot.landed);
    if (landed && landed !== this.last[i]) this.landed.push({t, corners: soleCorners(sole, foot.landed)});
    if (foot.planned_down && !this.plannedDown[i])
      this.planned.push({t, corners: soleCorners(sole, foot.plan)});
    this.last[i] = landed;
    this.plannedDown[i] = foot.planned_down;
  }

  /// The last frame at or before a time, or -1.
  indexAt(t) {
    return lastUpTo(t + 1e-6, this.frames.length, (i) => this.frames[i].t);
  }

  /// Describes a landmark at a frame in words.
  landmarkText(index, id) {
    const counts = {found: 0, missed: 0, rejected: 0},
      {t} = this.frames[index],
      begin = this.begins.get(id),
      axes = this.mapAt(index).find(([own]) => own === id)?.[2];
    for (const {searches} of this.frames.slice(0, index + 1))
      for (const search of searches ?? []) if (search[0] === id) ++counts[search[6]];
    const sigma =
      axes && Math.max(...[0, 1, 2].map((k) => Math.hypot(axes[k], axes[k + 3], axes[k + 6]))) / 3;
    return [
      `landmark ${id}`,
      begin <= t ? `${(t - begin).toFixed(2)} s old` : 'not in the map yet',
      this.ends.get(id) <= t ? 'no longer in the map' : null,
      axes ? `σ ${+(1e3 * sigma).toPrecision(3)} mm along its longest axis` : 'position not stored',
      ...Object.entries(counts).map(([how, n]) => `${n} ${how}`)
    ]
      .filter(Boolean)
      .join(', ');
  }

  /// The frames with the stored maps at or before a frame, and after it.
  mapsAround(index) {
    const k = lastUpTo(index, this.maps.length, (i) => this.maps[i]);
    return [this.frames[this.maps[k]], this.frames[this.maps[k + 1]]];
  }

  /// The landmarks in the map after a frame, at their last stored positions; new ones at their first.
  mapAt(index) {
    if (!this.frames[index]) return [];
    const [last, next] = this.mapsAround(index),
      {t} = this.frames[index],
      isIn = ([id]) => this.begins.get(id) <= t && !(this.ends.get(id) <= t),
      old = (last?.map ?? []).filter(isIn),
      known = new Set(old.map(([id]) => id)),
      isNew = ([id]) => !known.has(id) && this.begins.get(id) > last?.t;
    return [...old, ...(next?.map ?? []).filter((row) => isIn(row) && isNew(row))];
  }

  /// States how many landmarks the map has after a frame, and when their positions were stored.
  mapText(index) {
    const {landmarks} = this.frames[index],
      [last, next] = this.mapsAround(index),
      rows = this.mapAt(index),
      later = rows.filter(([id]) => this.begins.get(id) > last?.t).length,
      absent = landmarks - rows.length;
    const parts = [
      last && `positions of ${last.t.toFixed(1)} s`,
      later > 0 && `${later} of ${next.t.toFixed(1)} s`,
      rows.length > 0 && absent > 0 && `${absent} not stored`
    ];
    return `${landmarks} landmarks (${parts.filter(Boolean).join(', ') || 'no positions'})`;
  }
}
