// Strips over time: lines with bands, and a cursor at the time that is shown.
import {color, element} from '../../pages/web/dom.js';

const kLeft = 44, kBottom = 18, kTop = 6, kRight = 8;
const mm = (x) => (x === null || x === undefined ? null : 1000 * x);
const deg = (x) => (x === null || x === undefined ? null : 180 / Math.PI * x);

/// What is drawn: value and, where there is one, the half width of the band of each line at a frame.
const axis = (k, name, role, unit) => ({name, role, value: (f) => unit(f.error?.[k]), band: (f) => unit(f.sigma && 3 * f.sigma[k])});
export const kStrips = [
  {title: 'Position error with 3σ', unit: 'mm', lines: [axis(0, 'x', 'estimate', mm), axis(1, 'y', 'plan', mm), axis(2, 'z', 'first', mm)]},
  {title: 'Heading error with 3σ', unit: '°', lines: [axis(3, 'heading', 'estimate', deg)]},
  {title: 'NEES of the position (3 expected, 95 % below 7.8)', unit: '', from: 0, levels: [3, 7.81], lines: [{name: 'NEES', role: 'estimate', value: (f) => f.nees}]},
  {title: 'Landmarks', unit: '', from: 0, lines: [{name: 'in the map', role: 'first', value: (f) => f.landmarks},
    {name: 'found', role: 'estimate', value: (f) => f.searches?.filter((s) => s[6] === 'found').length}]},
  {title: 'Slip of the standing soles', unit: 'mm', from: 0, lines: [{name: 'left', role: 'estimate', value: (f) => mm(f.slip?.[0])},
    {name: 'right', role: 'plan', value: (f) => mm(f.slip?.[1])}]},
  {title: 'ZMP: distance inside the support polygon', unit: 'mm', levels: [0], lines: [{name: 'margin', role: 'estimate', value: (f) => mm(f.margin)}]},
];

const finite = (x) => x !== null && x !== undefined && Number.isFinite(x);
const short = (x) => (finite(x) ? String(+x.toPrecision(3)) : '–');

/// 1, 2 or 5 times a power of ten: at most five steps of it fit the range.
function stepOf(range) {
  const raw = range / 5, power = 10 ** Math.floor(Math.log10(raw));
  return [1, 2, 5, 10].find((m) => m * power >= raw) * power;
}

export class Strip {
  /// go(t): where a click leads.
  constructor(what, run, go) {
    Object.assign(this, {what, run, read: 0, values: what.lines.map(() => []), bands: what.lines.map(() => [])});
    this.low = what.from ?? Infinity;
    this.high = -Infinity;
    this.canvas = element('canvas', {role: 'img', 'aria-label': `${what.title} over time`,
      onclick: (event) => go(this.timeAt(event.offsetX))});
    this.legend = element('span', {class: 'values'});
    this.element = element('figure', {class: 'strip'}, element('figcaption', {}, what.title + (what.unit ? `, ${what.unit}` : '')), this.canvas, this.legend);
  }

  readFrames() {
    for (; this.read < this.run.frames.length; ++this.read) {
      const frame = this.run.frames[this.read];
      this.what.lines.forEach((line, k) => {
        const value = line.value(frame), band = line.band?.(frame);
        this.values[k].push(finite(value) ? value : null);
        this.bands[k].push(finite(band) ? band : null);
        if (!finite(value)) return;
        this.low = Math.min(this.low, value, finite(band) ? -band : value);
        this.high = Math.max(this.high, value, finite(band) ? band : value);
      });
    }
  }

  timeAt(x) { return (x - kLeft) / (this.canvas.clientWidth - kLeft - kRight) * this.end; }

  draw(index) {
    this.readFrames();
    const {canvas} = this, ratio = Math.min(devicePixelRatio, 2), width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    if (canvas.width !== Math.round(ratio * width)) { canvas.width = Math.round(ratio * width); canvas.height = Math.round(ratio * height); }
    const context = canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = '11px system-ui, sans-serif';
    this.end = Math.max(this.run.about.duration, this.run.duration, 1);
    if (this.high <= this.low || !Number.isFinite(this.high)) {
      if (!Number.isFinite(this.high)) return this.sayNothing(context);
      this.high = this.low + 1;
    }
    const margin = 0.05 * (this.high - this.low), low = this.what.from ?? this.low - margin, high = this.high + margin;
    const x = (t) => kLeft + (width - kLeft - kRight) * t / this.end;
    const y = (v) => kTop + (height - kTop - kBottom) * (high - v) / (high - low);
    this.axes(context, {x, y, low, high, width, height});
    context.save();
    context.beginPath();
    context.rect(kLeft, kTop, width - kLeft - kRight, height - kTop - kBottom);
    context.clip();
    this.what.lines.forEach((line, k) => this.band(context, x, y, k, line));
    this.what.lines.forEach((line, k) => this.line(context, x, y, k, line));
    context.restore();
    const now = this.run.frames[index];
    if (now) this.cursor(context, x(now.t), height);
    this.say(index);
  }

  sayNothing(context) {
    context.fillStyle = color('soft');
    context.fillText('no data', kLeft, 24);
  }

  axes(context, {x, y, low, high, width, height}) {
    context.strokeStyle = color('edge');
    context.fillStyle = color('soft');
    context.lineWidth = 1;
    context.textAlign = 'right';
    const step = stepOf(high - low);
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) {
      context.beginPath(); context.moveTo(kLeft, y(v)); context.lineTo(width - kRight, y(v)); context.stroke();
      context.fillText(String(+v.toPrecision(6)), kLeft - 5, y(v) + 4);
    }
    context.textAlign = 'center';
    const stepX = stepOf(this.end);
    for (let t = 0; t <= this.end; t += stepX) context.fillText(`${+t.toPrecision(6)} s`, Math.min(x(t), width - 16), height - 4);
    context.setLineDash([5, 4]);
    context.strokeStyle = color('soft');
    for (const level of this.what.levels ?? []) {
      if (level < low || level > high) continue;
      context.beginPath(); context.moveTo(kLeft, y(level)); context.lineTo(width - kRight, y(level)); context.stroke();
    }
    context.setLineDash([]);
  }

  band(context, x, y, k, line) {
    const half = this.bands[k], {frames} = this.run;
    if (!line.band) return;
    context.fillStyle = color(line.role) + '22';
    context.beginPath();
    half.forEach((b, i) => { if (b !== null) context.lineTo(x(frames[i].t), y(b)); });
    for (let i = half.length - 1; i >= 0; --i) if (half[i] !== null) context.lineTo(x(frames[i].t), y(-half[i]));
    context.fill();
  }

  line(context, x, y, k, line) {
    context.strokeStyle = color(line.role);
    context.lineWidth = 1.4;
    context.beginPath();
    let pen = false;
    this.values[k].forEach((v, i) => {
      if (v === null) { pen = false; return; }
      const at = [x(this.run.frames[i].t), y(v)];
      if (pen) context.lineTo(...at); else context.moveTo(...at);
      pen = true;
    });
    context.stroke();
  }

  cursor(context, at, height) {
    context.strokeStyle = color('text');
    context.lineWidth = 1;
    context.beginPath(); context.moveTo(at, kTop); context.lineTo(at, height - kBottom); context.stroke();
  }

  say(index) {
    this.legend.replaceChildren(...this.what.lines.map((line, k) => {
      const name = element('b', {class: `role-${line.role}`}, line.name);
      return element('span', {}, name, ` ${short(this.values[k][index])}`);
    }));
  }
}
