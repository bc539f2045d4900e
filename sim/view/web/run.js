// A run as the page knows it: its frames, and what follows from one frame to the next.
//
// A frame: t (s); truth, plan, estimate: poses of the camera [x, y, z, qx, qy, qz, qw]; bodies: such poses of the robot's bodies, one
// after another; error, sigma: [x, y, z, heading]; ellipsoid: rows of the matrix that maps the unit sphere to the 3-sigma ellipsoid of
// the estimated position; nees; landmarks: how many; health (0 ok, 1 lost, 2 diverged) and state in words; searches: [landmark, u, v,
// half axes of the ellipse, its angle, outcome, u and v of the match]; begun: pixels of new landmarks; map: [landmark, position,
// ellipsoid] where it changed; feet (left, right): truth and plan [x, y, heading], planned_down, load (N); zmp, planned_zmp.
// m, rad, px.

const kLoaded_n = 60, kUnloaded_n = 20;

/// The corners of a sole at [x, y, heading].
export function soleCorners(sole, [x, y, heading]) {
  const [x0, y0, x1, y1] = sole, c = Math.cos(heading), s = Math.sin(heading);
  return [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(([a, b]) => [x + c * a - s * b, y + s * a + c * b]);
}

/// Counter-clockwise (Andrew's monotone chain).
export function convexHull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1 && cross(chain.at(-2), chain.at(-1), p) <= 0) chain.pop();
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}
const cross = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);

/// Distance of a point from the nearest edge of a convex polygon; negative outside.
export function marginInside(polygon, p) {
  const distances = polygon.map((a, i) => {
    const b = polygon[(i + 1) % polygon.length];
    return cross(a, b, p) / Math.hypot(b[0] - a[0], b[1] - a[1]);
  });
  return Math.min(...distances);
}

export class Run {
  constructor(about, index) {
    Object.assign(this, {about, index, frames: [], mapOf: [], landed: [], planned: [], images: new Map()});
    this.standing = [null, null];    // where each foot was set down, while it carries load
    this.plannedDown = [true, true];
  }

  get duration() { return this.frames.length ? this.frames.at(-1).t : this.about.duration; }

  append(frame) {
    if (this.frames.length && frame.t <= this.frames.at(-1).t) return false;
    this.mapOf.push(frame.map ? this.frames.length : this.mapOf.at(-1) ?? -1);
    if (frame.feet) this.followFeet(frame);
    this.frames.push(frame);
    return true;
  }

  /// Slip and footsteps follow from the frames before.
  followFeet(frame) {
    frame.slip = frame.feet.map((foot, i) => {
      if (foot.load > kLoaded_n && !this.standing[i]) {
        this.standing[i] = foot.truth;
        this.landed.push({t: frame.t, corners: soleCorners(this.about.sole, foot.truth)});
      } else if (foot.load < kUnloaded_n) {
        this.standing[i] = null;
      }
      if (foot.planned_down && (!this.plannedDown[i] || !this.frames.length))
        this.planned.push({t: frame.t, corners: soleCorners(this.about.sole, foot.plan)});
      this.plannedDown[i] = foot.planned_down;
      const from = this.standing[i];
      return from ? Math.hypot(foot.truth[0] - from[0], foot.truth[1] - from[1]) : null;
    });
    const carrying = frame.feet.filter((foot) => foot.load > kUnloaded_n);
    if (!carrying.length) return;
    frame.polygon = convexHull(carrying.flatMap((foot) => soleCorners(this.about.sole, foot.truth)));
    if (frame.zmp) frame.margin = marginInside(frame.polygon, frame.zmp);
  }

  /// The last frame at or before a time; -1: there is none.
  indexAt(t) {
    let low = -1, high = this.frames.length;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.frames[middle].t <= t + 1e-6) low = middle;
      else high = middle;
    }
    return low;
  }

  mapAt(index) { return this.frames[this.mapOf[index]]?.map ?? []; }
}
