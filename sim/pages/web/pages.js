// Behavior of all pages: figures with a cursor, scatter plots of runs, selection of the run that is shown,
// and printing.
import {element, sortable} from './dom.js';
import {Figure, drawn, follow} from './figures.js';

const all = (selector, within = document) => [...within.querySelectorAll(selector)];

/// Counts the visible and the drawn figures, for tests of the page.
function count() {
  const figures = all('[data-figure]').filter((figure) => !figure.closest('[hidden]')),
    {dataset} = document.documentElement;
  dataset.figures = figures.length;
  dataset.drawn = figures.filter((figure) => figure.querySelector('svg')).length;
}

function showRun(id) {
  for (const run of all('.run')) run.hidden = run.id !== id;
  const chooser = document.getElementById('run');
  if (chooser) chooser.value = id;
  count();
}

const kRoles = ['estimate', 'first', 'second', 'third'];

function scatter(holder) {
  const {metrics, settings} = JSON.parse(holder.dataset.runs),
    known = metrics
      .map((_, i) => i)
      .filter((i) =>
        Object.values(settings)
          .flat()
          .some((values) => values[i] !== null)
      );
  const choice = (name, at) =>
    element(
      'select',
      {'aria-label': name, onchange: () => draw()},
      known.map((i) => element('option', {value: i, selected: i === known[at] ? '' : null}, metrics[i]))
    );
  const across = choice('metric along x', 0),
    up = choice('metric along y', 1),
    place = element('div');
  function draw() {
    const lines = Object.entries(settings).map(([name, runs], k) => ({
      name,
      role: kRoles[k % kRoles.length],
      dots: true,
      x: runs.map((values) => values[across.value] ?? NaN),
      y: runs.map((values) => values[up.value] ?? NaN)
    }));
    const figure = drawn({
      name: 'scatter',
      title: `${metrics[up.value]} over ${metrics[across.value]}: one dot per run`,
      lines,
      overTime: false,
      width: 560,
      height: 300
    });
    place.replaceChildren(figure.holder);
    follow([figure]);
  }
  holder.append(element('p', {class: 'no-print'}, up, ' over ', across), place);
  draw();
}

follow(
  all('figure')
    .filter((holder) => holder.querySelector('svg[data-x]'))
    .map((holder) => new Figure(holder))
);
all('.scatter').forEach(scatter);
document.getElementById('run')?.addEventListener('change', (event) => showRun(event.target.value));
for (const link of all('[data-run]')) link.addEventListener('click', () => showRun(link.dataset.run));
all('table.sortable').forEach(sortable);
// Everything is expanded for printing.
let opened = [];
addEventListener('beforeprint', () => {
  opened = all('details:not([open])');
  opened.forEach((details) => {
    details.open = true;
  });
});
addEventListener('afterprint', () =>
  opened.forEach((details) => {
    details.open = false;
  })
);
count();
