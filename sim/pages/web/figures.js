// Cursor and zoom of figures, which all time plots share, and figures drawn from columns. Pages contain
// figures drawn by the program (html.cc), together with their columns.

import {button, element} from './dom.js';

const kSvg = 'http://www.w3.org/2000/svg',
  kNear_px = 8;
const svgElement = (tag, attributes = {}, text = '') => {
  const node = document.createElementNS(kSvg, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(text);
  return node;
};
/// A grid line with its value. d: its path; place: attributes of the text.
const gridLine = (value, d, place) => [
  svgElement('path', {class: 'grid', d}),
  svgElement('text', place, String(+value.toPrecision(6)))
];
const short = (value) => String(+value.toPrecision(4));

class Axis {
  constructor(text) {
    [this.low, this.high, this.begin, this.end, this.logarithmic] = text.split(' ').map(Number);
    [this.scale, this.back] = this.logarithmic ? [Math.log, Math.exp] : [(v) => v, (v) => v];
  }
  get range() {
    return this.scale(this.high) - this.scale(this.low);
  }
  at(value) {
    return this.begin + ((this.end - this.begin) * (this.scale(value) - this.scale(this.low))) / this.range;
  }
  value(px) {
    return this.back(this.scale(this.low) + ((px - this.begin) / (this.end - this.begin)) * this.range);
  }
}

/// Multiples of 1, 2 or 5 times a power of ten.
function ticks(low, high, about = 8) {
  const rough = (high - low) / about,
    power = 10 ** Math.floor(Math.log10(rough)),
    step = [1, 2, 5, 10].find((m) => m * power >= rough) * power;
  return Array.from(
    {length: Math.floor(high / step) - Math.ceil(low / step) + 1},
    (_, i) => (Math.ceil(low / step) + i) * step
  );
}

/// The index of the last element of an ascending list that does not exceed a value, or -1.
export function lastUpTo(value, count, at) {
  let low = -1,
    high = count;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (at(middle) <= value) low = middle;
    else high = middle;
  }
  return low;
}

/// The index of the value nearest to x.
function nearest(values, x, isSorted) {
  if (isSorted) {
    const i = Math.max(
      0,
      lastUpTo(x, values.length, (k) => values[k])
    );
    return values[i + 1] - x < x - values[i] ? i + 1 : i;
  }
  let best = 0;
  for (let i = 1; i < values.length; ++i) if (Math.abs(values[i] - x) < Math.abs(values[best] - x)) best = i;
  return best;
}

/// The columns that the program stored in a figure: float32 in Base64, and for each part of the legend the
/// numbers of its columns.
function embedded({dataset: {columns, parts}}) {
  if (parts === undefined) return [];
  const numbers = columns
    .split(' ')
    .map((text) => new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer));
  return parts.split(';').map((part) => part.split(' ').map((column) => numbers[column]));
}

export class Figure {
  /// columns: [x, y] or [x, low, high] of each part of the legend.
  constructor(holder, columns) {
    this.holder = holder;
    this.svg = holder.querySelector('svg[data-x]');
    this.data = holder.querySelector('svg.data');
    this.whole = new Axis(this.svg.dataset.x);
    this.x = new Axis(this.svg.dataset.x);
    this.y = new Axis(this.svg.dataset.y);
    this.wholeY = new Axis(this.svg.dataset.y);
    this.overTime = this.svg.dataset.overTime === 'yes';
    this.label = this.overTime ? 'time [s]' : 'x';
    this.parts = columns ?? embedded(holder);
    this.items = [...holder.querySelectorAll('.legend b')];
    this.shown = null;
    this.cursor = svgElement('path', {class: 'cursor', d: ''});
    this.isSorted = this.overTime && Boolean(columns);
    // The cursor has a drawing of its own, because every change of a drawing paints all its lines again.
    const plot = element('div', {class: 'plot'});
    this.svg.replaceWith(plot);
    plot.append(
      this.svg,
      svgElement('svg', {viewBox: this.svg.getAttribute('viewBox'), 'aria-hidden': true}, this.cursor)
    );
  }

  get range() {
    return [this.x.low, this.x.high];
  }
  get isZoomed() {
    return this.x.low !== this.whole.low || this.x.high !== this.whole.high;
  }

  /// The x value under the mouse, clamped to the axes.
  valueAt(event) {
    const box = this.svg.getBoundingClientRect(),
      px = ((event.clientX - box.left) * this.svg.viewBox.baseVal.width) / box.width;
    return this.x.value(Math.min(Math.max(px, this.x.begin), this.x.end));
  }

  show(x) {
    const px = this.x.at(x),
      inside = px >= this.x.begin && px <= this.x.end;
    this.shown = x;
    this.cursor.setAttribute('d', inside ? `M${px} ${this.y.end}V${this.y.begin}` : '');
    this.parts.forEach((part, i) => {
      this.items[i].textContent = this.read(part, x);
    });
    const at = this.holder.querySelector('.legend .at');
    if (at) at.textContent = `${this.label}: ${short(x)}`;
  }

  read([at, ...values], x) {
    const i = nearest(at, x, this.isSorted);
    if (
      !at.length ||
      Math.abs(this.x.at(at[i]) - this.x.at(x)) >= kNear_px ||
      !values.every((column) => Number.isFinite(column[i]))
    )
      return '';
    return values.map((column) => short(column[i])).join(' to ');
  }

  /// The range of y of the lines over the shown range of x.
  shownRange() {
    const {lines, zero} = this.rescaled,
      isShown = (x) => x >= this.x.low && x <= this.x.high;
    return rangeOf(
      lines.map(({x, y, isOff}) => y.filter((_, i) => isShown(x[i]) && !(isOff?.[i] > 0))),
      zero
    );
  }

  drawTicksOfY() {
    const {x, y} = this;
    const lineOf = (v) =>
      gridLine(v, `M${x.begin} ${y.at(v)}H${x.end}`, {x: x.begin - 5, y: y.at(v) + 4, 'text-anchor': 'end'});
    this.svg.querySelector('.y-ticks').replaceChildren(...ticks(y.low, y.high, 6).flatMap(lineOf));
  }

  hide() {
    this.shown = null;
    this.cursor.setAttribute('d', '');
    for (const text of this.holder.querySelectorAll('.legend b, .legend .at')) text.textContent = '';
  }

  /// Shows a range of x, and of y if the figure was drawn here.
  zoom(low, high) {
    const from = this.whole.at(low);
    let {y, height} = this.data.viewBox.baseVal;
    Object.assign(this.x, {low, high});
    if (this.rescaled) {
      [this.y.low, this.y.high] = this.isZoomed ? this.shownRange() : [this.wholeY.low, this.wholeY.high];
      y = this.wholeY.at(this.y.high);
      height = this.wholeY.at(this.y.low) - y;
      this.drawTicksOfY();
    }
    this.data.setAttribute('viewBox', `${from} ${y} ${this.whole.at(high) - from} ${height}`);
    this.svg.classList.toggle('zoomed', this.isZoomed);
    this.svg.querySelector('.ticks').replaceChildren(
      ...ticks(low, high).flatMap((v) =>
        gridLine(v, `M${this.x.at(v)} ${this.y.begin}V${this.y.end}`, {
          x: this.x.at(v),
          y: this.y.begin + 16,
          'text-anchor': 'middle'
        })
      )
    );
    if (this.shown !== null) this.show(this.shown);
  }
}

const kMargin = 0.05,
  kLeft = 46,
  kRight = 10,
  kTop = 8,
  kBottom = 20;

/// A path through points, interrupted at non-finite ones. Points less than a tenth of a pixel from the
/// previous one are omitted.
function pathOf(x, y, at) {
  let d = '',
    lastX = -1e9,
    lastY = -1e9,
    down = false;
  for (let i = 0; i < x.length; ++i) {
    const [px, py] = at(x[i], y[i]);
    if (!Number.isFinite(py)) {
      down = false;
      continue;
    }
    if (down && Math.hypot(px - lastX, py - lastY) < 0.1) continue;
    d += `${down ? 'L' : 'M'}${px.toFixed(2)} ${py.toFixed(2)}`;
    [lastX, lastY, down] = [px, py, true];
  }
  return d;
}

/// A dot for each point: a stroke of zero length with round ends.
const dotsOf = (x, y, at) =>
  x
    .map((v, i) => at(v, y[i]))
    .filter((place) => place.every(Number.isFinite))
    .map(([px, py]) => `M${px.toFixed(2)} ${py.toFixed(2)}h0`)
    .join('');

/// The area between two lines, interrupted at each gap.
function areaOf(x, low, high, at) {
  let d = '';
  for (let i = 0, begin = 0; i <= x.length; ++i) {
    if (i < x.length && Number.isFinite(low[i] + high[i])) continue;
    const part = (column) => Array.from(column.slice(begin, i)),
      there = part(x);
    if (there.length)
      d += pathOf(there.concat(part(x).reverse()), part(high).concat(part(low).reverse()), at) + 'Z';
    begin = i + 1;
  }
  return d;
}

const hidden = new Set(); // parts of figures, remembered when figures are redrawn
const asked = new Set(); // parts that have been drawn

/// A button in a legend that hides a part's path or shows it again.
function hider(key, role, text, path) {
  const apply = (to) => {
    path.classList.toggle('off', hidden.has(key));
    to.setAttribute('aria-pressed', !hidden.has(key));
  };
  const toggle = (pressed) => {
    if (!hidden.delete(key)) hidden.add(key);
    apply(pressed);
  };
  const own = button([text, element('b')], 'show or hide', toggle, {class: `role-${role}`});
  apply(own);
  return own;
}

/// The range of all finite values, with a margin.
function rangeOf(columns, more = []) {
  let low = Math.min(...more),
    high = Math.max(...more);
  for (const column of columns) {
    for (const v of column.filter(Number.isFinite)) {
      if (v < low) low = v;
      if (v > high) high = v;
    }
  }
  if (low > high) [low, high] = [0, 1];
  const margin = kMargin * (high - low || Math.abs(high) || 1);
  return [low - margin, high + margin];
}

/// The path of a line or a band. at(x, y): its pixel. Where isOff is not 0, a line is faint.
function pathOfPart({x, y, low, high, role, dots, thin, dash, isOff}, at) {
  if (!y) return svgElement('path', {class: `fill envelope ${role}`, d: areaOf(x, low, high, at)});
  const kind = dots ? 'dots' : thin ? 'line thin' : 'line';
  const path = (values, more) =>
    svgElement('path', {class: `${kind} ${role}`, d: (dots ? dotsOf : pathOf)(x, values, at), ...more});
  const dashes = dash ? {'stroke-dasharray': dash} : {};
  if (!isOff?.some((v) => v > 0)) return path(y, dashes);
  return svgElement(
    'g',
    {},
    path(
      y.map((v, i) => (isOff[i] > 0 ? NaN : v)),
      dashes
    ),
    path(
      y.map((v, i) => (isOff[i] > 0 || isOff[i + 1] > 0 ? v : NaN)),
      {'stroke-dasharray': '1 4'}
    )
  );
}

/// Returns an empty drawing, with its axes as attributes for Figure, and an inner one that clips lines.
function frameOf(title, overTime, width, height, [x, y]) {
  const place = {x: kLeft, y: kTop, width: width - kLeft - kRight, height: height - kTop - kBottom};
  const attributes = {'data-x': x, 'data-y': y, 'data-over-time': overTime ? 'yes' : 'no'};
  const svg = svgElement('svg', {
    viewBox: `0 0 ${width} ${height}`,
    role: 'img',
    'aria-label': title,
    ...attributes
  });
  const viewBox = Object.values(place).join(' ');
  const data = svgElement('svg', {class: 'data', ...place, viewBox, preserveAspectRatio: 'none'});
  svg.append(svgElement('g', {class: 'ticks'}), data, svgElement('rect', {class: 'frame', ...place}));
  return {svg, data};
}

/// Draws a figure. overTime: x is time. lines: [{name, role, x, y, thin, dots, dash, isOff}]; bands: [{name,
/// role, x, low, high, starts}], hidden at first if starts is false; levels: values of y; marks: [{t, text}]; zero: include 0 on the y axis.
export function drawn({name, title, lines, bands = [], levels = [], marks = [], ...more}) {
  const {zero = false, overTime = true, width = 400, height = 150} = more;
  const columns = lines.map(({y, isOff}) => y.filter((_, i) => !(isOff?.[i] > 0)));
  const texts = [
    `${rangeOf(lines.map(({x}) => x)).join(' ')} ${kLeft} ${width - kRight} 0`,
    `${rangeOf(columns, zero ? [0, ...levels] : levels).join(' ')} ${height - kBottom} ${kTop} 0`
  ];
  const [x, y] = texts.map((text) => new Axis(text)),
    at = (a, b) => [x.at(a), y.at(b)];
  const {svg, data} = frameOf(title, overTime, width, height, texts);
  data.before(svgElement('g', {class: 'y-ticks'}));
  const level = (d, text) => svgElement('path', {class: 'level', d}, svgElement('title', {}, String(text)));
  const parts = [...lines, ...bands],
    paths = new Map(parts.map((part) => [part, pathOfPart(part, at)]));
  data.append(
    ...bands.map((band) => paths.get(band)),
    ...levels.map((v) => level(`M${x.begin} ${y.at(v)}H${x.end}`, v)),
    ...marks.map(({t, text}) => level(`M${x.at(t)} ${y.begin}V${y.end}`, text)),
    ...lines.map((line) => paths.get(line))
  );
  const named = parts.filter((part) => part.name);
  const buttonOf = (part) => {
    const key = `${name}/${part.name}`;
    if (part.starts === false && !asked.has(key)) hidden.add(key);
    asked.add(key);
    return hider(key, part.role, `${part.name} `, paths.get(part));
  };
  const legend = named.flatMap((part) => [buttonOf(part), ' ']);
  const holder = element(
    'figure',
    {'data-figure': name},
    element('figcaption', {}, title),
    svg,
    element('p', {class: 'legend'}, element('span', {class: 'at'}), ' ', legend)
  );
  const figure = new Figure(
    holder,
    named.map((part) => (part.y ? [part.x, part.y] : [part.x, part.low, part.high]))
  );
  figure.rescaled = {lines, zero: zero ? [0, ...levels] : levels};
  figure.zoom(x.low, x.high);
  return figure;
}

/// Makes the figures follow the mouse: moving shows values, a drag zooms, a double click shows everything.
/// With scrubs, a drag selects x instead, and the wheel zooms (with Ctrl outside a footer). chosen(x,
/// goesOn): on a click and during a drag; left(): when the mouse has left; zoomed(): after a zoom.
export function follow(figures, chosen, left, zoomed, scrubs = false) {
  const peers = (figure) => (figure.overTime ? figures.filter((other) => other.overTime) : [figure]);
  const zoom = (figure, low, high) => {
    peers(figure).forEach((peer) => peer.zoom(low, high));
    zoomed?.();
  };
  for (const figure of figures) {
    let from = null;
    figure.svg.addEventListener('pointerdown', (event) => {
      from = event.clientX;
      figure.from = figure.valueAt(event);
    });
    figure.svg.addEventListener('pointermove', (event) => {
      if (scrubs && from !== null) chosen?.(figure.valueAt(event), true);
      peers(figure).forEach((peer) => peer.show(figure.valueAt(event)));
    });
    figure.svg.addEventListener(
      'wheel',
      (event) => {
        if (!scrubs || !(event.ctrlKey || figure.holder.closest('footer'))) return;
        event.preventDefault();
        const at = figure.valueAt(event),
          factor = event.deltaY > 0 ? 1.25 : 0.8,
          {
            x: {low, high},
            whole
          } = figure;
        zoom(
          figure,
          Math.max(whole.low, at + factor * (low - at)),
          Math.min(whole.high, at + factor * (high - at))
        );
      },
      {passive: false}
    );
    figure.svg.addEventListener('pointerleave', () => {
      from = null;
      peers(figure).forEach((peer) => peer.hide());
      left?.();
    });
    figure.svg.addEventListener('pointerup', (event) => {
      if (from === null) return;
      const [low, high] = [figure.from, figure.valueAt(event)].sort((a, b) => a - b);
      if (scrubs || Math.abs(event.clientX - from) < 5) chosen?.(figure.valueAt(event));
      else if (!figure.x.logarithmic) zoom(figure, low, high);
      from = null;
    });
    figure.svg.addEventListener('dblclick', () => zoom(figure, figure.whole.low, figure.whole.high));
  }
}
