// The elements of the page.
import {button, choice, element, sortable} from '../../pages/web/dom.js';
import {searchLegend} from './pane.js';

const kSpeeds = [
  [0, 'full speed'],
  [4, '4 ×'],
  [2, '2 ×'],
  [1, '1 ×'],
  [0.5, '0.5 ×'],
  [0.25, '0.25 ×']
];
const kViews = [
  ['follow', 'follow the robot'],
  ['orbit', 'stay'],
  ['head', 'through the camera']
];

/// Properties shared by all runs of a page.
export function titleOf(runs) {
  const [{label, scenario, seed}] = runs;
  if (runs.length === 1) return label;
  return runs.every((run) => run.seed === seed) ? `${scenario}, seed ${seed}` : scenario;
}

/// The buttons that show and hide the layers of the scene. toggle(name, isShown).
export function layerLegend(panes, toggle) {
  const layer = (name, role, text) =>
    button(text, 'show or hide', (pressed) => toggle(name, pressed.ariaPressed !== 'true'), {
      'data-layer': name,
      'aria-pressed': String(!name.startsWith('errors')),
      class: `layer role-${role}`
    });
  const several = panes.length > 1;
  const ofRun = ({name, role}, i) => [
    layer(`estimate${i}`, role, several ? `— ${name}` : '— estimated'),
    layer(`map${i}`, several ? role : 'first', several ? `● landmarks of ${name}` : '● landmarks, 3σ'),
    layer(`errors${i}`, role, several ? `⬤ error of ${name}` : '⬤ error on the path, 3σ')
  ];
  return element(
    'p',
    {class: 'key'},
    layer('truth', 'truth', '— true'),
    layer('plan', 'plan', '— planned'),
    layer('steps', 'landed', '▭ steps'),
    panes.flatMap(ofRun),
    ' camera’s own 3σ enlarged ten times; landmarks’ 3σ up to 0.5 m'
  );
}

/// The table of differences between the runs, as sent by the program, and the marks below it. go(t): goes to a
/// row's worst instant.
export function changesTable({titles, rows}, panes, go, marks) {
  const role = (i) => (panes[i - 1] ? `role-${panes[i - 1].role}` : '');
  const title = (text, t) => (t === null ? text : button(text, 'go to its worst instant', () => go(t)));
  const valuesOf = (values) =>
    panes.map(({name}, i) => element('div', {class: role(i + 1)}, `${name}: ${values[i]}`));
  const keyRow = ([key, ...values]) => [
    element('td', {}, key),
    element('td', {colspan: titles.length - 1}, valuesOf(values))
  ];
  const metricRow = (cells, t) =>
    cells.map((text, i) => element('td', {class: role(i)}, i ? text : title(text, t)));
  const head = titles.map((text, i) => element('th', {class: role(i), scope: 'col'}, text));
  const body = rows.map(({key, cells, remark, t}) =>
    element('tr', {title: remark}, key ? keyRow(cells) : metricRow(cells, t))
  );
  const table = element(
    'table',
    {},
    element('thead', {}, element('tr', {}, head)),
    element('tbody', {}, body)
  );
  sortable(table);
  return element(
    'section',
    {class: 'changes scroll', tabindex: 0, 'aria-label': 'what differs between the runs'},
    table,
    marks
  );
}

/// The controls below the scene. page: the object they act on.
export function controls(page) {
  const {player, scene} = page;
  const all = {
    play: button('', 'space', () => player.toggle()),
    slider: element('input', {
      type: 'range',
      min: 0,
      max: 1,
      step: 0.001,
      value: 0,
      'aria-label': 'time',
      oninput: ({currentTarget}) => player.go(+currentTarget.value)
    }),
    clock: element('output', {}, '0.00 s'),
    step: button('step', 'one frame: .', () => player.step()),
    speeds: choice('f: full speed, 1: real time, 4: a quarter', kSpeeds, (value) => page.setSpeed(+value), {
      'aria-label': 'speed'
    }),
    views: choice('r, o, c', kViews, (value) => page.setMode(value), {'aria-label': 'view'}),
    split:
      page.panes.length > 1
        ? button('split', 'v: one view per run, moved together', () => page.setSplit(!scene.isSplit))
        : null,
    seen: choice(
      'i',
      [
        ['seen', 'images as the filter got them'],
        ['recorded', 'images as recorded']
      ],
      (value) => page.setSeen(value === 'seen'),
      {'aria-label': 'images', hidden: page.panes.some(({isSeen}) => isSeen) ? null : ''}
    ),
    save: button('save picture', 's: save the scene as PNG', () => page.savePicture())
  };
  all.speeds.value = player.live ? 0 : 1;
  if (player.live && !player.control) {
    for (const control of [all.speeds, all.step]) {
      control.disabled = true;
      control.title = 'read-only; start the run with --control';
    }
  }
  return all;
}

/// Adds everything to the document.
export function build(page) {
  const {about, panes, scene, landmarks, plots, player} = page;
  const several = panes.length > 1,
    heads = panes.filter(({first}) => !first).length;
  const names = panes.map(({name, role}) => element('b', {class: `role-${role}`}, element('span', {}, name)));
  scene.element.append(element('div', {class: 'names', 'aria-hidden': 'true'}, names));
  const title = titleOf(about.runs),
    legend = layerLegend(panes, (name, on) => page.setLayer(name, on));
  const views = element(
    'div',
    {class: `views${several ? ' several' : ''}`},
    several ? changesTable(about.changes, panes, (t) => player.go(t), page.moments.element) : null,
    element('figure', {class: 'space'}, scene.element, legend, landmarks.text),
    element(
      'figure',
      {class: `head heads-${heads}`},
      panes.map((pane) => pane.element),
      searchLegend(panes[0].shared.length > 1)
    )
  );
  document.body.append(
    element(
      'header',
      {},
      element('h1', {}, player.live ? 'GaitSLAM, live' : 'GaitSLAM, playback'),
      element('b', {}, title),
      page.note,
      page.why
    ),
    element(
      'main',
      {},
      views,
      element(
        'div',
        {class: 'rig'},
        page.rig.map((layer) => layer.element)
      ),
      plots.names,
      plots.strips
    ),
    element(
      'footer',
      {},
      plots.timeLine,
      element('div', {class: 'controls'}, Object.values(page.controls)),
      several ? null : page.moments.element
    )
  );
  document.title = `GaitSLAM: ${[title, ...panes.map(({full}) => full)].filter(Boolean).join(' | ')}`;
}
