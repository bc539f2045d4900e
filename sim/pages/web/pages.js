// Behavior of all pages: figures with a cursor, the run that is shown, and printing.
import {sortable} from './dom.js';
import {Figure, follow} from './figures.js';

const all = (selector, within = document) => [...within.querySelectorAll(selector)];

/// Shows a time of a run below a figure, with the nearest image.
function showInstant(figure, t) {
  const instant = figure.holder.querySelector('.instant');
  if (!instant) return;
  const link = instant.querySelector('a');
  all('span', instant).forEach((time) => { time.textContent = t.toFixed(2); });
  if (!link) return;
  const images = all('[data-t]', figure.holder.closest('.run'));
  const nearest = images.reduce((a, b) => (Math.abs(b.dataset.t - t) < Math.abs(a.dataset.t - t) ? b : a));
  link.setAttribute('href', `#${nearest.id}`);
  link.textContent = `image at ${nearest.dataset.t} s`;
}

/// Counts the visible figures and those that are drawn, for tests of the page.
function count() {
  const figures = all('[data-figure]').filter((figure) => !figure.closest('[hidden]')), {dataset} = document.documentElement;
  dataset.figures = figures.length;
  dataset.drawn = figures.filter((figure) => figure.querySelector('svg, canvas, .undrawn')).length;
}

function showRun(id) {
  for (const run of all('.run')) run.hidden = run.id !== id;
  const chooser = document.getElementById('run');
  if (chooser) chooser.value = id;
  dispatchEvent(new Event('drawmaps'));
  count();
}

follow(all('figure').filter((holder) => holder.querySelector('svg[data-x]')).map((holder) => new Figure(holder)), showInstant);
document.getElementById('run')?.addEventListener('change', (event) => showRun(event.target.value));
for (const link of all('[data-run]')) link.addEventListener('click', () => showRun(link.dataset.run));
all('table.sortable').forEach(sortable);
addEventListener('mapdrawn', count);
// Paper gets everything opened.
let opened = [];
addEventListener('beforeprint', () => {
  opened = all('details:not([open])');
  opened.forEach((details) => { details.open = true; });
});
addEventListener('afterprint', () => opened.forEach((details) => { details.open = false; }));
count();
