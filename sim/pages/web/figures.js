// A figure's data drawn with a cursor that all figures over time share; figures with equal axes come as SVG.
import Dygraph from 'dygraphs/src/dygraph.js';
import {color, countDrawn, countExpected, element, tick} from './dom.js';

const drawn = [];

const isTime = (figure) => figure.x_label.startsWith('time');

/// The columns of a figure: its lines, then both edges of each envelope.
function columnsOf(figure) {
  const edges = figure.envelopes.flatMap((e) => [['low', e.low], ['high', e.high]].map(([edge, y]) => (
    {name: `${e.name}, ${edge}`, x: e.x, y, stroke: () => color(e.role) + '66', options: {strokeWidth: 1}})));
  const lines = figure.lines.map((line) => ({name: line.name || 'run', x: line.x, y: line.y, stroke: () => color(line.role),
    options: line.dots ? {strokeWidth: 0, drawPoints: true, pointSize: 2.5} : {strokeWidth: 1.6}}));
  const names = new Set();
  return [...lines, ...edges].map((column) => {
    let name = column.name;
    for (let k = 2; names.has(name); ++k) name = `${column.name} ${k}`;
    names.add(name);
    return {...column, name};
  });
}

/// One row per x, ascending; columns that have several values at one x have several rows there.
function rowsOf(columns, logarithmic) {
  const points = columns.flatMap(({x, y}, column) => x.map((at, i) => ({at, column, y: y[i]})));
  points.sort((a, b) => a.at - b.at);
  const rows = [];
  let first = 0;  // of the rows of the present x
  for (const {at, column, y} of points) {
    if (rows.length === first || rows[first][0] !== at) first = rows.length;
    const value = logarithmic && !(y > 0) ? null : y;
    let row = rows.slice(first).find((candidate) => candidate[1 + column] === null);
    if (!row) rows.push(row = [at, ...columns.map(() => null)]);
    row[1 + column] = value;
  }
  return rows;
}

function fillEnvelope(context, chart, {x, low, high, role}) {
  context.fillStyle = color(role) + '2a';
  context.beginPath();
  x.forEach((at, i) => context.lineTo(...chart.toDomCoords(at, high[i])));
  for (let i = x.length - 1; i >= 0; --i) context.lineTo(...chart.toDomCoords(x[i], low[i]));
  context.fill();
}

/// Envelopes, levels and moments are drawn below the lines.
const underlay = (figure) => (context, area, chart) => {
  context.save();
  for (const envelope of figure.envelopes) fillEnvelope(context, chart, envelope);
  context.strokeStyle = context.fillStyle = color('soft');
  context.setLineDash([6, 5]);
  const stroke = (x0, y0, x1, y1) => { context.beginPath(); context.moveTo(x0, y0); context.lineTo(x1, y1); context.stroke(); };
  for (const {y} of figure.levels) {
    const at = chart.toDomYCoord(y);
    if (at > area.y && at < area.y + area.h) stroke(area.x, at, area.x + area.w, at);
  }
  for (const {name, x} of figure.moments) {
    const at = chart.toDomXCoord(x);
    stroke(at, area.y, at, area.y + area.h);
    context.fillText(name, at + 6, area.y + 14);
  }
  context.restore();
};

const colors = (columns) => ({colors: columns.map(({stroke}) => stroke()), axisLineColor: color('edge'), gridLineColor: color('edge')});

/// The row nearest to x.
function nearestRow(rows, x) {
  let low = 0, high = rows.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (rows[middle][0] < x) low = middle;
    else high = middle;
  }
  return Math.abs(rows[low][0] - x) <= Math.abs(rows[high][0] - x) ? low : high;
}

const othersOverTime = (chart) => drawn.filter((other) => other.overTime && other.chart !== chart);

/// The cursor of a figure over time is shown in all of them.
const sharedCursor = {
  highlightCallback(_, x) { for (const {chart, rows} of othersOverTime(this)) chart.setSelection(nearestRow(rows, x)); },
  unhighlightCallback() { for (const {chart} of othersOverTime(this)) chart.clearSelection(); },
};

/// Without a cursor the legend names the lines; at the cursor it has the values of those that have one there.
function legendOf(data) {
  const named = (series) => `${series.dashHTML} ${series.labelHTML}`;
  const span = (series, text) => `<span style="color:${series.color}">${text}</span>`;
  if (data.x === undefined) return data.series.filter((s) => s.isVisible).map((s) => span(s, named(s))).join(' ');
  const here = data.series.filter((s) => s.isVisible && s.yHTML);
  return `<span>${data.xHTML}</span> ` + here.map((s) => span(s, `${named(s)} ${s.yHTML}`)).join(' ');
}

/// Figures whose greatest value is what a reader asks about first; of the others that is the middle.
const hasPeak = ({name}) => ['error_', 'nees', 'nis', 'closure', 'correct', 'slip', 'landing', 'cpu'].some((begin) => name.startsWith(begin));

/// Where the first line is farthest from zero.
function peakOf({x, y}) {
  let best = 0;
  y.forEach((value, i) => { if (value !== null && Math.abs(value) > Math.abs(y[best] ?? 0)) best = i; });
  return x[best];
}

/// Says how to see an instant of a run: the command of the view, and the nearest image of this page.
function instantElement(run) {
  const shown = element('p', {class: 'soft instant no-print'});
  const show = (t, word) => {
    const nearest = run.pictures.reduce((best, picture, i) => (
      best < 0 || Math.abs(picture.t - t) < Math.abs(run.pictures[best].t - t) ? i : best), -1);
    shown.replaceChildren(`${word} ${t.toFixed(2)} s: `, element('code', {}, run.view), ' and ', element('code', {}, `#t=${t.toFixed(2)}`),
      ' after its address', ...(nearest < 0 ? [] : ['; ', element('a', {href: `#picture-${nearest}`}, `image at ${run.pictures[nearest].t} s`)]));
  };
  return {shown, show};
}

const whole = {pixelsPerLabel: 50, ticker: (a, b, pixels) => {
  const step = Math.max(1, Math.ceil((b - a) / Math.max(1, pixels / 50)));
  const ticks = [];
  for (let v = Math.ceil(a / step) * step; v <= b; v += step) ticks.push({v, label: String(v)});
  return ticks;
}};

/// Powers of ten; over fewer than two decades 2 and 5 times them too.
const decades = {ticker: (a, b) => {
  const ticks = [], low = Math.max(a, b * 1e-12);
  for (let exponent = Math.floor(Math.log10(low)); exponent <= Math.log10(b); ++exponent)
    for (const v of (b >= 100 * low ? [1] : [1, 2, 5]).map((factor) => factor * 10 ** exponent)) if (v >= low && v <= b) ticks.push({v, label: tick(v)});
  return ticks.length > 1 ? ticks : multiples(a, b);
}};

/// About four multiples of 1, 2 or 5 times a power of ten.
function multiples(a, b) {
  const rough = (b - a) / 4, power = 10 ** Math.floor(Math.log10(rough)), step = [1, 2, 5, 10].find((factor) => factor * power >= rough) * power;
  const ticks = [];
  for (let k = Math.ceil(a / step); k * step <= b; ++k) ticks.push({v: k * step, label: tick(k * step)});
  return ticks;
}
const tickerOf = (figure) => (figure.logarithmic ? decades : figure.whole_y ? whole : {});

function plot(figure, holder, run) {
  const instant = run && isTime(figure) && figure.lines.some(({x}) => x.length) ? instantElement(run) : null;
  const columns = columnsOf(figure), rows = rowsOf(columns, figure.logarithmic), overTime = isTime(figure);
  const canvas = element('div', {class: 'plot'}), legend = element('div', {class: 'legend'});
  holder.append(canvas, legend, ...(instant ? [instant.shown] : []));
  const chart = new Dygraph(canvas, rows, {
    ...colors(columns), ...(overTime ? sharedCursor : {}), labels: [figure.x_label, ...columns.map(({name}) => name)],
    series: Object.fromEntries(columns.map(({name, options}) => [name, options])), xlabel: figure.x_label, ylabel: figure.y_label,
    logscale: figure.logarithmic, xRangePad: 4, yRangePad: 4, connectSeparatedPoints: true, legend: 'always', labelsDiv: legend, labelsSeparateLines: false,
    legendFormatter: legendOf, ...(instant ? {clickCallback: (_, x) => instant.show(x, 'at')} : {}), underlayCallback: underlay(figure), axes: {
      x: {valueFormatter: (x) => `${figure.x_label}: ${x.toPrecision(4)}`, axisLabelFormatter: tick, drawGrid: true, ...(figure.whole_x ? whole : {})},
      y: {valueFormatter: (y) => y.toPrecision(4), axisLabelFormatter: tick, axisLabelWidth: 56, ...tickerOf(figure)}},
  });
  drawn.push({chart, columns, rows, overTime});
  new ResizeObserver(() => chart.resize()).observe(holder);
  if (instant) {
    const line = figure.lines.find(({x}) => x.length);
    if (hasPeak(figure)) instant.show(peakOf(line), `${line.name} greatest at`);
    else instant.show(line.x[line.x.length >> 1], 'at');
  }
  countDrawn();
}

/// Links below a figure: of one run the command that shows it, of several the runs that it shows.
function linksOf(figure, run, runLinks) {
  if (run && !isTime({x_label: figure.x_label ?? ''}))
    return element('p', {class: 'soft no-print'}, 'this run: ', element('code', {}, run.view));
  const links = run ? [] : runLinks(figure.runs ?? []);
  return links.length ? element('p', {class: 'soft no-print'}, 'runs: ', links) : null;
}

/// A figure's element; it is drawn when it has a place on the page.
export function figureElement(figure, run = null, runLinks = () => []) {
  const holder = element('div', {'data-figure': figure.name});
  const shown = element('figure', {}, element('figcaption', {}, figure.title), holder);
  countExpected();
  if (figure.svg) {
    holder.innerHTML = figure.svg;
    countDrawn();
  } else {
    setTimeout(() => plot(figure, holder, run));
  }
  const links = linksOf(figure, run, runLinks);
  if (links) shown.append(links);
  return shown;
}

/// Colours follow the theme.
export function redrawFigures() {
  for (const {chart, columns} of drawn) chart.updateOptions(colors(columns));
}
