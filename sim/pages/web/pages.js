// Behavior of all pages: sorted tables, figures with a cursor, the run that is shown, the theme, and printing.
import {element, toggleTheme} from './dom.js';
import {Figure, follow} from './figures.js';

const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const numberOf = (cell) => (cell.classList.contains('number') ? parseFloat(cell.textContent) : NaN);

/// A click on a title sorts, another one reverses. Cells without a value come last.
function makeSortable(table) {
  const body = table.tBodies[0], titles = all('th', table);
  titles.forEach((title, column) => title.querySelector('button').addEventListener('click', () => {
    const sign = title.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
    const compare = (a, b) => {
      const [x, y] = [a, b].map((row) => numberOf(row.cells[column]));
      if (!Number.isNaN(x) && !Number.isNaN(y)) return sign * (x - y);
      if (Number.isNaN(x) !== Number.isNaN(y)) return Number.isNaN(x) ? 1 : -1;
      return sign * a.cells[column].textContent.localeCompare(b.cells[column].textContent);
    };
    body.append(...[...body.rows].sort(compare));
    titles.forEach((other) => other.removeAttribute('aria-sort'));
    title.setAttribute('aria-sort', sign > 0 ? 'ascending' : 'descending');
  }));
}

const kOnPaper = 8;  // runs side by side

/// Paper cannot scroll a wide table: it gets a line for each column and some rows side by side.
function addPaperTables(table) {
  const titles = all('th', table), rows = [...table.tBodies[0].rows], chunks = [];
  for (let i = 0; i < rows.length; i += kOnPaper) chunks.push(rows.slice(i, i + kOnPaper));
  const line = (chunk, title, column) => element('tr', {}, element('th', {}, title.textContent),
    chunk.map((row) => element('td', {class: 'number'}, row.cells[column].textContent)));
  const scroll = table.closest('.scroll');
  scroll.classList.add('no-print');
  scroll.after(element('div', {class: 'only-print'}, chunks.map((chunk) =>
    element('table', {class: 'named-rows'}, element('tbody', {}, titles.map((title, column) => line(chunk, title, column)))))));
}

/// Shows a time of a run below a figure, with the nearest image.
function showInstant(figure, t) {
  const instant = figure.holder.querySelector('.instant');
  if (!instant) return;
  const [word, ...times] = all('span', instant), link = instant.querySelector('a');
  word.textContent = 'at';
  times.forEach((time) => { time.textContent = t.toFixed(2); });
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

let themeOfScreen, opened = [];
const setTheme = (theme) => {
  if (theme) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
  dispatchEvent(new Event('themechange'));
};

all('table.sortable').forEach((table) => { makeSortable(table); addPaperTables(table); });
follow(all('figure').filter((holder) => holder.querySelector('svg[data-x]')).map((holder) => new Figure(holder)), showInstant);
document.getElementById('run')?.addEventListener('change', (event) => showRun(event.target.value));
for (const link of all('[data-run]')) link.addEventListener('click', () => showRun(link.dataset.run));
for (const button of all('.copy')) {
  button.addEventListener('click', () => navigator.clipboard?.writeText(button.previousElementSibling.textContent)
    .then(() => { button.textContent = 'copied'; }));
}
document.getElementById('theme').addEventListener('click', () => { toggleTheme(); dispatchEvent(new Event('themechange')); });
addEventListener('mapdrawn', count);
// Paper is white and has no controls: it gets the light colors and everything opened.
addEventListener('beforeprint', () => {
  themeOfScreen = document.documentElement.dataset.theme;
  setTheme('light');
  opened = all('details:not([open])');
  opened.forEach((details) => { details.open = true; });
});
addEventListener('afterprint', () => {
  setTheme(themeOfScreen);
  opened.forEach((details) => { details.open = false; });
});
count();
