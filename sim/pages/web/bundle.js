// The page of a report: reads the data that the program wrote into it and fills the body.
import {copyable, element, number, scroll, section} from './dom.js';
import {figureElement, redrawFigures} from './figures.js';
import {repaintScenes, sceneElement} from './scene.js';
import {limitsTable, metricsTable, paperTables, sortableTable} from './tables.js';

const data = JSON.parse(document.getElementById('data').textContent);

const kCards = ['ate_se3_rmse_m', 'rmse_m', 'end_position_error_m', 'end_yaw_error_deg', 'loop_landmarks', 'nees_position_mean',
  'navigation_rmse_m', 'navigation_end_position_error_m', 'navigation_end_yaw_error_deg'];

function verdict(run) {
  const good = run.exit_code === 0;
  return element('span', {class: `verdict ${good ? 'good' : 'bad'}`}, run.verdict);
}

function cards(run) {
  const shown = kCards.filter((name) => typeof run.score.metrics[name]?.value === 'number' && (run.steered || !name.startsWith('navigation')));
  return element('div', {class: 'cards'}, shown.map((name) => {
    const {value, unit} = run.score.metrics[name];
    const [factor, text] = unit === 'm' ? [1000, 'mm'] : [1, unit === '1' ? '' : unit];
    const expected = name.startsWith('nees') ? ' (3 expected)' : '';
    return element('div', {class: 'card'}, element('b', {}, `${number(+(factor * value).toPrecision(4))} ${text}`),
      element('span', {class: 'soft'}, name.replace(/_(m|deg)$/, '') + expected));
  }));
}

const figures = (list, run = null) => element('div', {class: 'figures'}, list.map((figure) => figureElement(figure, run, runLinks)));
const named = (run, names) => run.figures.filter((f) => names.some((name) => f.name.startsWith(name)));

function strip(run) {
  const explained = 'Ellipses are the search regions of landmarks (3 sigma), green with the matched 11 x 11 patch where the match was used, yellow otherwise.';
  return element('div', {}, element('p', {class: 'soft'}, explained), element('div', {class: 'strip'}, run.pictures.map((picture, i) => {
    const holder = element('div');
    holder.innerHTML = picture.svg;
    return element('figure', {id: `picture-${i}`}, holder, element('span', {class: 'soft'}, `${picture.t} s`));
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

function closureText(run) {
  const m = run.score.metrics, value = (name) => m[name]?.value;
  if (value('loop_time_s') === null || value('loop_time_s') === undefined)
    return element('p', {class: 'soft'}, `The loop was not closed: ${m.loop_closed?.reason ?? 'no landmark of the first quarter was recognised'}.`);
  return element('p', {}, `The loop was closed at ${number(value('loop_time_s'))} s by ${number(value('loop_landmarks'))} landmarks of the first quarter. The position `
    + `error was ${number(1000 * value('loop_error_before_m'))} mm before and ${number(1000 * value('loop_error_after_m'))} mm one second after.`);
}

function sections(run) {
  const all = [
    section('verdict', data.runs.length > 1 ? run.label : 'Verdict', element('p', {}, verdict(run), ' ', run.cause, run.counterfactual ? ` Counterfactual: ${run.counterfactual}.` : '', run.alignment ? ` ${run.alignment}` : ''), cards(run),
      run.score.limits.length ? limitsTable(run.score.limits) : element('p', {class: 'soft'}, 'The scenario sets no limits.')),
    section('paths', 'Plan, truth and estimate', figures(named(run, ['from_above', 'waist_from_above', 'height', 'correct']), run)),
  ];
  if (run.has_estimate) {
    all.push(section('errors', 'Errors with 3-sigma envelopes', figures(named(run, ['error_']), run)),
      section('consistency', 'Consistency', figures(named(run, ['nees', 'nis']), run)),
      section('loop', 'Loop closure', closureText(run), figures(named(run, ['closure', 'matches']), run)));
  }
  if (named(run, ['slip', 'landing']).length) all.push(section('slip', 'Slip, step by step', figures(named(run, ['slip', 'landing']), run)));
  if (run.pictures.length) all.push(section('pictures', 'Images of the head camera', strip(run)));
  if (run.scene) all.push(section('map', 'Map', sceneElement(run.scene)));
  if (named(run, ['cpu']).length) all.push(section('cpu', 'CPU time', figures(named(run, ['cpu']), run)));
  all.push(section('metrics', 'All metrics', metricsTable(run.score.metrics, data.definitions)),
    section('configuration', 'Configuration', configuration(run)),
    section('again', 'See it and run it again', element('p', {class: 'soft'}, 'The view plays the run in a browser; #t=SECONDS after its address opens it at that instant.'),
      copyable(run.view), copyable(run.command)));
  return all;
}

/// The table and the figures of runs that may be compared: those of one scenario.
function comparison(runs, id, title, shown) {
  const names = [...new Set(runs.flatMap((run) => Object.keys(run.score.metrics)))].filter((name) =>
    runs.some((run) => typeof run.score.metrics[name]?.value === 'number'));
  const columns = [{title: 'run', text: true, value: (run) => run.label, href: (run) => (run.figures ? '#body' : null), open: show},
    {title: 'verdict', text: true, value: (run) => run.verdict}, {title: 'ending', text: true, value: (run) => run.score.ending},
    ...names.map((name) => ({title: name.replaceAll('_', ' '), value: (run) => run.score.metrics[name]?.value ?? null}))];
  return section(id, title, sortableTable(columns, runs), paperTables(columns, runs), figures(shown));
}

/// One section for each scenario: results of different scenarios are never pooled.
function comparisons() {
  const scenarios = [...new Set(data.runs.map((run) => run.scenario))];
  if (scenarios.length === 1) return [comparison(data.runs, 'runs', 'Run by run', data.figures)];
  const parts = scenarios.map((name, i) => {
    const runs = data.runs.filter((run) => run.scenario === name), folders = new Set(runs.map((run) => run.folder));
    return comparison(runs, `scenario-${i}`, `${name}: run by run`, data.figures.filter((f) => f.runs?.some((folder) => folders.has(folder))));
  });
  return [navigation(parts), ...parts];
}

/// Links to runs by their folders; of runs that the page does not show in full the label alone.
function runLinks(folders) {
  return folders.flatMap((folder) => {
    const run = data.runs.find((candidate) => candidate.folder === folder);
    if (!run) return [];
    const label = run.label.replace(`${run.scenario}, `, '');
    return [run.figures ? element('a', {href: '#body', onclick: () => show(run)}, label) : element('span', {}, label), ' '];
  });
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

const body = element('main', {id: 'body'});
const inFull = data.runs.filter((run) => run.figures);
const chooser = element('select', {'aria-label': 'run shown below', onchange: () => show(inFull[+chooser.value])},
  inFull.map((run, i) => element('option', {value: i}, run.label)));

function show(run) {
  const parts = sections(run);
  chooser.value = inFull.indexOf(run);
  body.replaceChildren(navigation(parts), ...parts);
}

function page() {
  document.body.append(
    element('header', {}, element('div', {}, element('h1', {}, data.title), element('p', {class: 'soft'}, data.subtitle)), themeButton()));
  if (data.runs.length > 1) {
    const left = data.runs.length - inFull.length;
    document.body.append(...comparisons(), element('p', {class: 'no-print'}, 'Shown below: ', chooser));
    if (left > 0) document.body.append(element('p', {class: 'soft'},
      `In full are the first and the worst run of each scenario; ${left} others have a page of their own by tools/gaitslam report FOLDER.`));
  }
  document.body.append(body);
  show(inFull[0]);
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
