// Cursor and zoom of figures that the program drew (html.cc). Figures over time share both.

const kSvg = 'http://www.w3.org/2000/svg', kNear_px = 8;
const svgElement = (tag, attributes) => {
  const node = document.createElementNS(kSvg, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return node;
};
const short = (value) => String(+value.toPrecision(4));

class Axis {
  constructor(text) {
    [this.low, this.high, this.begin, this.end, this.logarithmic] = text.split(' ').map(Number);
    [this.scale, this.back] = this.logarithmic ? [Math.log, Math.exp] : [(v) => v, (v) => v];
  }
  get range() { return this.scale(this.high) - this.scale(this.low); }
  at(value) { return this.begin + (this.end - this.begin) * (this.scale(value) - this.scale(this.low)) / this.range; }
  value(px) { return this.back(this.scale(this.low) + (px - this.begin) / (this.end - this.begin) * this.range); }
}

/// Multiples of 1, 2 or 5 times a power of ten.
function ticks(low, high) {
  const rough = (high - low) / 8, power = 10 ** Math.floor(Math.log10(rough)), step = [1, 2, 5, 10].find((m) => m * power >= rough) * power;
  return Array.from({length: Math.floor(high / step) - Math.ceil(low / step) + 1}, (_, i) => (Math.ceil(low / step) + i) * step);
}

const pointsOf = (path) => [...path.getAttribute('d').matchAll(/[ML]([-\d.]+) ([-\d.]+)/g)].map(([, x, y]) => [+x, +y]);
const nearest = (points, px) => points.reduce((best, p) => (Math.abs(p[0] - px) < Math.abs((best?.[0] ?? Infinity) - px) ? p : best), null);

export class Figure {
  constructor(holder) {
    this.holder = holder;
    this.svg = holder.querySelector('svg[data-x]');
    this.data = holder.querySelector('svg.data');
    this.whole = new Axis(this.svg.dataset.x);
    this.x = new Axis(this.svg.dataset.x);
    this.y = new Axis(this.svg.dataset.y);
    this.overTime = this.svg.dataset.overTime === 'yes';
    this.label = this.overTime ? 'time [s]' : 'x';
    const named = (selector) => [...this.data.querySelectorAll(`path[data-name]:not([data-name=""])${selector}`)];
    this.paths = [...named(':not(.envelope)'), ...named('.envelope')];  // as in the legend
    this.items = [...holder.querySelectorAll('.legend [data-name] b')];
    this.cursor = svgElement('path', {class: 'cursor', d: ''});
    this.svg.append(this.cursor);
  }

  /// The value of x under the mouse, within the axes.
  valueAt(event) {
    const box = this.svg.getBoundingClientRect(), px = (event.clientX - box.left) * this.svg.viewBox.baseVal.width / box.width;
    return this.x.value(Math.min(Math.max(px, this.x.begin), this.x.end));
  }

  show(x) {
    const px = this.x.at(x), inside = px >= this.x.begin && px <= this.x.end;
    this.cursor.setAttribute('d', inside ? `M${px} ${this.y.end}V${this.y.begin}` : '');
    this.points ??= this.paths.map(pointsOf);
    this.points.forEach((points, i) => { this.items[i].textContent = this.read(this.paths[i], points, this.whole.at(x)); });
    const at = this.holder.querySelector('.legend .at');
    if (at) at.textContent = `${this.label}: ${short(x)}`;
  }

  read(path, points, px) {
    const value = (some) => { const p = nearest(some, px); return p && Math.abs(p[0] - px) < kNear_px ? String(+this.y.value(p[1]).toPrecision(3)) : ''; };
    if (!path.classList.contains('envelope')) return value(points);
    const half = points.length / 2, [low, high] = [value(points.slice(half)), value(points.slice(0, half))];
    return low && high ? `${low} to ${high}` : '';
  }

  hide() {
    this.cursor.setAttribute('d', '');
    for (const text of this.holder.querySelectorAll('.legend b, .legend .at')) text.textContent = '';
  }

  zoom(low, high) {
    const {viewBox: {baseVal: {y, height}}} = this.data, from = this.whole.at(low);
    Object.assign(this.x, {low, high});
    this.data.setAttribute('viewBox', `${from} ${y} ${this.whole.at(high) - from} ${height}`);
    this.svg.classList.toggle('zoomed', low !== this.whole.low || high !== this.whole.high);
    this.svg.querySelector('.ticks').replaceChildren(...ticks(low, high).flatMap((v) => {
      const text = svgElement('text', {x: this.x.at(v), y: this.y.begin + 16, 'text-anchor': 'middle'});
      text.textContent = +v.toPrecision(6);
      return [svgElement('path', {class: 'grid', d: `M${this.x.at(v)} ${this.y.begin}V${this.y.end}`}), text];
    }));
  }
}

/// Makes the figures follow the mouse: move shows values, drag zooms, double click shows all. chosen(figure, x): on a click. left(): it left.
export function follow(figures, chosen, left) {
  const peers = (figure) => (figure.overTime ? figures.filter((other) => other.overTime) : [figure]);
  for (const figure of figures) {
    let from = null;
    figure.svg.addEventListener('pointerdown', (event) => { from = event.clientX; figure.from = figure.valueAt(event); });
    figure.svg.addEventListener('pointermove', (event) => peers(figure).forEach((peer) => peer.show(figure.valueAt(event))));
    figure.svg.addEventListener('pointerleave', () => { from = null; peers(figure).forEach((peer) => peer.hide()); left?.(); });
    figure.svg.addEventListener('pointerup', (event) => {
      if (from === null) return;
      const [low, high] = [figure.from, figure.valueAt(event)].sort((a, b) => a - b);
      if (Math.abs(event.clientX - from) < 5) chosen?.(figure, high);
      else if (!figure.x.logarithmic) peers(figure).forEach((peer) => peer.zoom(low, high));
      from = null;
    });
    figure.svg.addEventListener('dblclick', () => peers(figure).forEach((peer) => peer.zoom(peer.whole.low, peer.whole.high)));
  }
}
