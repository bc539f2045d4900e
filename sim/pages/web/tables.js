// Tables: verdict and metrics of one run, and many runs side by side, sorted by a click or the keyboard.
import {element, number, scroll} from './dom.js';

const limitText = (limit) => ('at_most' in limit ? `≤ ${number(limit.at_most)}` : `≥ ${number(limit.at_least)}`);

export function limitsTable(limits) {
  const rows = limits.map((limit) => element('tr', {},
    element('td', {}, limit.metric), element('td', {class: 'number'}, number(limit.value)),
    element('td', {class: 'number'}, limitText(limit)),
    element('td', {class: limit.passed ? 'good' : 'bad'}, limit.passed === null ? 'not judged' : limit.passed ? 'passed' : 'MISSED')));
  return scroll('limits', element('table', {class: 'named-rows'},
    element('thead', {}, element('tr', {}, element('th', {}, 'limit on'), element('th', {class: 'number'}, 'value'),
      element('th', {class: 'number'}, 'limit'), element('th', {}, 'verdict'))), element('tbody', {}, rows)));
}

/// A reason that several metrics share stands once, below the table.
function sharedReasons(metrics) {
  const all = Object.values(metrics).map(({reason}) => reason).filter(Boolean);
  return [...new Set(all)].filter((reason) => all.indexOf(reason) !== all.lastIndexOf(reason));
}

export function metricsTable(metrics, definitions) {
  const shared = sharedReasons(metrics);
  const why = (reason) => (shared.includes(reason) ? `not defined here (${shared.indexOf(reason) + 1})` : `not defined here: ${reason}`);
  const rows = Object.entries(metrics).map(([name, metric]) => element('tr', {},
    element('td', {}, element('code', {}, name)),
    element('td', {class: 'number'}, metric.value === null ? '–' : number(metric.value)),
    element('td', {}, metric.unit === '1' ? '' : metric.unit),
    element('td', {class: 'soft'}, metric.reason ? why(metric.reason) : definitions[name] ?? '')));
  return element('div', {}, scroll('metrics', element('table', {class: 'named-rows'},
    element('thead', {}, element('tr', {}, ['metric', 'value', 'unit', 'what it is'].map((title, i) =>
      element('th', {class: i === 1 ? 'number' : null}, title)))), element('tbody', {}, rows))),
  shared.map((reason, i) => element('p', {class: 'soft'}, `(${i + 1}) ${reason}`)));
}

const kOnPaper = 8;  // runs side by side

/// What paper shows of a sortable table, which it cannot scroll: a line for each column, some rows side by side.
export function paperTables(columns, rows) {
  const chunks = [];
  for (let i = 0; i < rows.length; i += kOnPaper) chunks.push(rows.slice(i, i + kOnPaper));
  const line = (chunk, {title, value}) => element('tr', {}, element('th', {}, title), chunk.map((row) =>
    element('td', {class: 'number'}, typeof value(row) === 'string' ? value(row) : number(value(row)))));
  return element('div', {class: 'only-print'}, chunks.map((chunk) =>
    element('table', {class: 'named-rows'}, element('tbody', {}, columns.map((column) => line(chunk, column))))));
}

/// columns: [{title, value(row) -> number or text}]. A click on a title sorts, a second one turns the order.
export function sortableTable(columns, rows) {
  const body = element('tbody');
  let sortedBy = null, ascending = true;
  const fill = (ordered) => body.replaceChildren(...ordered.map((row) => element('tr', {}, columns.map((column) => {
    const value = column.value(row);
    const numeric = typeof value === 'number' || value === null;
    const href = column.href?.(row), shown = numeric ? number(value) : value;
    return element('td', {class: numeric ? 'number' : null},
      href ? element('a', {href, onclick: () => column.open(row)}, shown) : shown);
  }))));
  const sort = (column, header) => {
    ascending = sortedBy === column ? !ascending : true;
    sortedBy = column;
    const key = (row) => column.value(row) ?? Infinity;
    const sign = ascending ? 1 : -1;
    fill([...rows].sort((a, b) => sign * (key(a) < key(b) ? -1 : key(a) > key(b) ? 1 : 0)));
    for (const other of header.parentNode.children) other.removeAttribute('aria-sort');
    header.setAttribute('aria-sort', ascending ? 'ascending' : 'descending');
  };
  const headers = columns.map((column) => {
    const header = element('th', {class: column.text ? null : 'number'});
    header.append(element('button', {type: 'button', onclick: () => sort(column, header)}, column.title));
    return header;
  });
  fill(rows);
  const table = element('table', {class: 'named-rows'}, element('thead', {}, element('tr', {}, headers)), body);
  return element('div', {class: 'no-print'}, scroll('runs', table));
}
