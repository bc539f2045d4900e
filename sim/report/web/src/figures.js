// A figure's data drawn with a cursor that all figures over time share; figures with equal axes come as SVG.
import uPlot from 'uplot';
import {color, countDrawn, countExpected, element} from './dom.js';

const drawn = [];

const isTime = (figure) => figure.x_label.startsWith('time');

/// Lines of different x on one axis: uPlot wants one x for all.
function joined(figure) {
  const tables = figure.lines.map((line) => [line.x, line.y]);
  for (const e of figure.envelopes) tables.push([e.x, e.low], [e.x, e.high]);
  const sorted = tables.map(([x, y]) => {
    const order = x.map((_, i) => i).sort((a, b) => x[a] - x[b]);
    return [order.map((i) => x[i]), order.map((i) => y[i])];
  });
  const distinct = sorted.every(([x]) => x.every((v, i) => i === 0 || v > x[i - 1]));
  return distinct ? uPlot.join(sorted) : scattered(sorted);
}

/// Several points of the same x: a table of its own, one row a point.
function scattered(tables) {
  const x = tables.flatMap(([values]) => values);
  let before = 0;
  const columns = tables.map(([, values]) => {
    const column = new Array(x.length).fill(null);
    values.forEach((value, i) => { column[before + i] = value; });
    before += values.length;
    return column;
  });
  return [x, ...columns];
}

function series(figure) {
  const lines = figure.lines.map((line) => ({
    label: line.name || 'run', stroke: () => color(line.role), width: 1.6, spanGaps: !line.dots,
    paths: line.dots ? () => null : undefined, points: {show: line.dots, size: 4, fill: () => color(line.role)},
    value: (_, v) => (v === null || v === undefined ? '–' : v.toPrecision(4)),
  }));
  const edges = figure.envelopes.flatMap((e) => ['low', 'high'].map((edge) => ({
    label: `${e.name}, ${edge}`, stroke: () => color(e.role) + '66', width: 1, spanGaps: true, points: {show: false},
    value: (_, v) => (v === null || v === undefined ? '–' : v.toPrecision(4)),
  })));
  return [{label: figure.x_label}, ...lines, ...edges];
}

function bands(figure) {
  const first = 1 + figure.lines.length;
  return figure.envelopes.map((e, i) => ({series: [first + 2 * i + 1, first + 2 * i], fill: () => color(e.role) + '2a'}));
}

/// Levels and moments are not data: drawn over the picture.
function overlays(figure) {
  return {hooks: {draw: [(plot) => {
    const {ctx, bbox} = plot;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = color('soft');
    ctx.setLineDash([6, 5]);
    ctx.textAlign = 'left';
    const stroke = (x0, y0, x1, y1) => { ctx.beginPath(); ctx.moveTo(x0, y0); ctx.lineTo(x1, y1); ctx.stroke(); };
    for (const {y} of figure.levels) {
      const at = plot.valToPos(y, 'y', true);
      if (at > bbox.top && at < bbox.top + bbox.height) stroke(bbox.left, at, bbox.left + bbox.width, at);
    }
    for (const {name, x} of figure.moments) {
      const at = plot.valToPos(x, 'x', true);
      stroke(at, bbox.top, at, bbox.top + bbox.height);
      ctx.fillText(name, at + 6, bbox.top + 14);
    }
    ctx.restore();
  }]}};
}

function axis(label) {
  return {label, labelSize: 22, stroke: () => color('text'), grid: {stroke: () => color('edge'), width: 1},
    ticks: {stroke: () => color('edge')}, size: label === undefined ? 40 : 56};
}

/// Nine lines a decade would be darker than what is drawn over them.
function valueAxis(figure) {
  const all = axis(figure.y_label);
  if (!figure.logarithmic) return all;
  const filter = (_, values) => values.map((v) => (Math.abs(Math.log10(v) - Math.round(Math.log10(v))) < 1e-6 ? v : null));
  return {...all, grid: {...all.grid, filter}, ticks: {...all.ticks, filter}};
}

function positive(figure, data) {
  if (!figure.logarithmic) return data;
  return data.map((column, i) => (i === 0 ? column : column.map((v) => (v > 0 ? v : null))));
}

function plot(figure, holder) {
  const size = () => ({width: Math.max(holder.clientWidth, 240), height: 250});
  const options = {
    ...size(), series: series(figure), bands: bands(figure), plugins: [overlays(figure)],
    cursor: isTime(figure) ? {sync: {key: 'time'}} : {}, scales: {x: {time: false}, y: {distr: figure.logarithmic ? 3 : 1}},
    axes: [{...axis(figure.x_label), size: 40}, valueAxis(figure)], legend: {live: true},
  };
  const chart = new uPlot(options, positive(figure, joined(figure)), holder);
  new ResizeObserver(() => chart.setSize(size())).observe(holder);
  drawn.push(chart);
  countDrawn();
}

/// A figure's element; it is drawn when it has a place on the page.
export function figureElement(figure) {
  const holder = element('div', {'data-figure': figure.name});
  const shown = element('figure', {}, element('figcaption', {}, figure.title), holder);
  countExpected();
  if (figure.svg) {
    holder.innerHTML = figure.svg;
    countDrawn();
  } else {
    setTimeout(() => plot(figure, holder));
  }
  return shown;
}

/// Colours follow the theme.
export function redrawFigures() {
  for (const chart of drawn) chart.redraw(false);
}
