// The page of a report: reads the data that the program wrote into it and fills the body.
import {element, number, scroll, section} from './dom.js';
import {figureElement, redrawFigures} from './figures.js';
import {repaintScenes, sceneElement} from './scene.js';
import {limitsTable, metricsTable, paperTables, sortableTable} from './tables.js';

const data = JSON.parse(document.getElementById('data').textContent);

const kCards = ['ate_se3_rmse_m', 'rmse_m', 'end_position_error_m', 'end_yaw_error_deg', 'loop_landmarks', 'nees_position_mean'];

function verdict(run) {
  const good = run.exit_code === 0;
  return element('span', {class: `verdict ${good ? 'good' : 'bad'}`}, run.verdict);
}

function cards(run) {
  const shown = kCards.filter((name) => run.score.metrics[name]?.value !== null && run.score.metrics[name]);
  return element('div', {class: 'cards'}, shown.map((name) => {
    const {value, unit} = run.score.metrics[name];
    const [factor, text] = unit === 'm' ? [1000, 'mm'] : [1, unit === '1' ? '' : unit];
    const expected = name.startsWith('nees') ? ' (3 expected)' : '';
    return element('div', {class: 'card'}, element('b', {}, `${number(+(factor * value).toPrecision(4))} ${text}`),
      element('span', {class: 'soft'}, name.replace(/_(m|deg)$/, '') + expected));
  }));
}

const figures = (list) => element('div', {class: 'figures'}, list.map(figureElement));
const named = (run, names) => run.figures.filter((f) => names.some((name) => f.name.startsWith(name)));

function strip(run) {
  const explained = 'Ellipses are the search regions of landmarks (3 sigma), green with the matched 11 x 11 patch where the match was used, yellow otherwise.';
  return element('div', {}, element('p', {class: 'soft'}, explained), element('div', {class: 'strip'}, run.pictures.map((picture) => {
    const holder = element('div');
    holder.innerHTML = picture.svg;
    return element('figure', {}, holder, element('span', {class: 'soft'}, `${picture.t} s`));
  })));
}

function configuration(run) {
  const rows = run.configuration.map((row) => element('tr', {}, element('td', {}, element('code', {}, row.key)),
    element('td', {}, element('code', {}, row.value)), element('td', {}, row.unit),
    element('td', {class: 'soft'}, row.origin)));
  return element('details', {}, element('summary', {}, `${rows.length} keys and where each was set`),
    scroll('configuration', element('table', {class: 'named-rows'}, element('thead', {}, element('tr', {},
      ['key', 'value', 'unit', 'from'].map((title) => element('th', {}, title)))), element('tbody', {}, rows))));
}

function copyable(text) {
  const button = element('button', {type: 'button', class: 'no-print', onclick: () => {
    navigator.clipboard?.writeText(text).then(() => { button.textContent = 'copied'; });
  }}, 'copy');
  return element('div', {}, element('pre', {}, text), button);
}

function closureText(run) {
  const m = run.score.metrics, value = (name) => m[name]?.value;
  if (value('loop_time_s') === null || value('loop_time_s') === undefined)
    return element('p', {class: 'soft'}, `The loop was not closed: ${m.loop_closed?.reason ?? 'no landmark of the first quarter was recognised'}.`);
  return element('p', {}, `The loop was closed at ${number(value('loop_time_s'))} s by ${number(value('loop_landmarks'))} landmarks of the first quarter. The position `
    + `error was ${number(1000 * value('loop_error_before_m'))} mm before and ${number(1000 * value('loop_error_after_m'))} mm one second after.`);
}

function sections(run) {
  const all = [
    section('verdict', data.runs.length > 1 ? run.label : 'Verdict', element('p', {}, verdict(run), ' ', run.cause, run.counterfactual ? ` Counterfactual: ${run.counterfactual}.` : ''), cards(run),
      run.score.limits.length ? limitsTable(run.score.limits) : element('p', {class: 'soft'}, 'The scenario sets no limits.')),
    section('paths', 'Plan, truth and estimate', figures(named(run, ['from_above', 'waist_from_above', 'height', 'correct']))),
  ];
  if (run.has_estimate) {
    all.push(section('errors', 'Errors with 3-sigma envelopes', figures(named(run, ['error_']))),
      section('consistency', 'Consistency', figures(named(run, ['nees', 'nis']))),
      section('loop', 'Loop closure', closureText(run), figures(named(run, ['closure', 'matches']))));
  }
  if (named(run, ['slip', 'landing']).length) all.push(section('slip', 'Slip, step by step', figures(named(run, ['slip', 'landing']))));
  if (run.pictures.length) all.push(section('pictures', 'Images of the head camera', strip(run)));
  if (run.scene) all.push(section('map', 'Map', sceneElement(run.scene)));
  if (named(run, ['cpu']).length) all.push(section('cpu', 'CPU time', figures(named(run, ['cpu']))));
  all.push(section('metrics', 'All metrics', metricsTable(run.score.metrics, data.definitions)),
    section('configuration', 'Configuration', configuration(run)),
    section('again', 'Run it again', copyable(run.command)));
  return all;
}

function comparison(runs) {
  const names = Object.keys(runs[0].score.metrics).filter((name) => runs.some((run) => run.score.metrics[name]?.value !== null));
  const columns = [{title: 'run', text: true, value: (run) => run.label}, {title: 'verdict', text: true, value: (run) => run.verdict},
    {title: 'ending', text: true, value: (run) => run.score.ending},
    ...names.map((name) => ({title: name.replaceAll('_', ' '), value: (run) => run.score.metrics[name]?.value ?? null}))];
  return section('runs', 'Run by run', sortableTable(columns, runs), paperTables(columns, runs), figures(data.figures));
}

function themeButton() {
  const root = document.documentElement;
  return element('button', {type: 'button', class: 'no-print', onclick: () => {
    const dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
    setTheme(dark ? 'light' : 'dark');
  }}, 'light / dark');
}

function navigation(parts) {
  return element('nav', {'aria-label': 'parts of this page'},
    parts.map((part) => element('a', {href: '#' + part.id}, part.querySelector('h2').textContent)));
}

function show(body, run) {
  const parts = sections(run);
  body.replaceChildren(navigation(parts), ...parts);
}

function page() {
  const body = element('main');
  const chooser = element('select', {'aria-label': 'run shown below', onchange: () => show(body, data.runs[+chooser.value])},
    data.runs.map((run, i) => element('option', {value: i}, run.label)));
  document.body.append(
    element('header', {}, element('div', {}, element('h1', {}, data.title), element('p', {class: 'soft'}, data.subtitle)), themeButton()));
  if (data.runs.length > 1) document.body.append(comparison(data.runs), element('p', {class: 'no-print'}, 'Shown below: ', chooser));
  document.body.append(body);
  show(body, data.runs[0]);
}

page();
// Paper is white and shows nothing on demand: what is printed has the light colours, and all that can be opened is open.
let themeOfScreen;
function setTheme(theme) {
  if (theme) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
  redrawFigures();
  repaintScenes();
}
let openedForPaper = [];
addEventListener('beforeprint', () => {
  themeOfScreen = document.documentElement.dataset.theme;
  setTheme('light');
  openedForPaper = [...document.querySelectorAll('details:not([open])')];
  openedForPaper.forEach((details) => { details.open = true; });
});
addEventListener('afterprint', () => {
  setTheme(themeOfScreen);
  openedForPaper.forEach((details) => { details.open = false; });
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { redrawFigures(); repaintScenes(); });
