// The page: one scene and one timeline for all runs, the images of each run, time plots, and keyboard control.
import {element, sortable} from '../../pages/web/dom.js';
import {follow} from '../../pages/web/figures.js';
import {Run} from './run.js';
import {Scene} from './scene.js';
import {Series, figures, kOnDemand, known, matched, partings, timeLine} from './compare.js';
import {Pane, searchLegend} from './pane.js';
import {RigLayer} from './sensors.js';
import {getBlob, getBytes, getJson, listen, picture} from './source.js';

const {dataset} = document.documentElement;
const kFast = 5;  // at full speed, the browser draws every fifth frame of a finished run

const kRoles = ['estimate', 'second', 'third', 'first'];  // of the runs
const kKeys = 'space: play or pause · arrows, . and ,: one frame, with shift one second · [ and ]: previous and next mark · home, end · f, 1, 4: speed · r, o, c: follow, stay, through the camera · v: one view per run · s: save the scene as PNG · in a figure: click or drag to go to a time, wheel to zoom (above the timeline: Ctrl and wheel), double-click to show everything, click a name in a legend to hide its line';
const kLetters = 'ABCD';  // names of the runs if there are several

/// The seed and the variant that distinguish each run from the others.
function differencesOf(runs) {
  const differ = (key) => new Set(runs.map((run) => run[key])).size > 1;
  return runs.map((run) => [differ('seed') && `seed ${run.seed}`, differ('variant') && run.variant].filter(Boolean).join(', '));
}

/// Waits until the browser has displayed what was drawn.
const drawnOnce = () => new Promise((resolve) => { requestAnimationFrame(() => setTimeout(resolve)); });

class Page {
  constructor(about) {
    Object.assign(this, {about, live: about.mode === 'live', t: 0, playing: about.mode === 'live', speed: 1, mode: 'follow', atEnd: true, figures: [], marks: [], hiddenStrips: new Set(kOnDemand)});
    const differences = differencesOf(about.runs), [{recording}] = about.runs, isOneWalk = recording && about.runs.every((run) => run.recording === recording);
    this.panes = [];
    about.runs.forEach((run, i) => this.panes.push(new Pane(new Run(run, i), about.runs.length > 1 ? kLetters[i] : '', differences[i], kRoles[i], isOneWalk ? this.panes[0] : null)));
    this.scene = new Scene(this.panes[0].run, this.panes.slice(1));
    this.scene.element.append(element('div', {class: 'names', 'aria-hidden': 'true'}, this.panes.map(({name, role}) => element('b', {class: `role-${role}`}, element('span', {}, name)))));
    // After a click in the scene, no other element may keep the keyboard focus either.
    this.scene.element.addEventListener('pointerup', () => document.activeElement.blur());
    let from = null;
    this.scene.element.addEventListener('pointerdown', ({clientX, clientY}) => { from = [clientX, clientY]; }, true);
    this.scene.element.addEventListener('click', (event) => {
      if (from && Math.hypot(event.clientX - from[0], event.clientY - from[1]) < 5) this.pick(this.scene.pick(event));  // otherwise the view was rotated
    });
    for (const {head, shared} of this.panes) {
      head.canvas.addEventListener('click', (event) => {
        const found = shared.map(({run, index}) => ({run: run.index, ...head.pick(event, run.frames[index] ?? {})})).sort((a, b) => a.far - b.far)[0];
        this.pick(found.id === undefined ? null : found);
      });
    }
    const [{run}] = this.panes;
    this.rig = run.about.rig.flatMap((sensor, i) => (sensor.kind === 'imu' ? [] : [new RigLayer(run, sensor, i, this.scene)]));
    this.build();
    addEventListener('keydown', (event) => this.key(event));
    addEventListener('hashchange', () => this.goToHash());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { this.scene.paint(); this.show(this.t); });
    new ResizeObserver(() => this.figures.length && this.width !== innerWidth && this.drawFigures()).observe(document.body);
  }

  build() {
    // After a mouse click, a button must not keep the keyboard focus.
    const button = (text, title, action, more = {}) => element('button', {type: 'button', title, ...more,
      onclick: (event) => { action(event.currentTarget); if (event.detail > 0) event.currentTarget.blur(); }}, text);
    const choice = (title, options, choose, more = {}) => element('select', {title, ...more, onchange: ({currentTarget}) => { choose(currentTarget.value); currentTarget.blur(); }},
      options.map(([value, text]) => element('option', {value}, text)));
    const several = this.panes.length > 1;
    this.button = button;
    this.play = button('', 'space', () => this.toggle());
    this.step = button('step', 'one frame: .', () => this.stepOn());
    this.speeds = choice('f: full speed, 1: real time, 4: a quarter', [[0, 'full speed'], [4, '4 ×'], [2, '2 ×'], [1, '1 ×'], [0.5, '0.5 ×'], [0.25, '0.25 ×']], (value) => this.setSpeed(+value), {'aria-label': 'speed'});
    this.views = choice('r, o, c', [['follow', 'follow the robot'], ['orbit', 'stay'], ['head', 'through the camera']], (value) => this.setMode(value), {'aria-label': 'view'});
    this.slider = element('input', {type: 'range', min: 0, max: 1, step: 0.001, value: 0, 'aria-label': 'time', oninput: () => this.go(+this.slider.value)});
    this.clock = element('output', {}, '0.00 s');
    this.save = button('save picture', 's: save the scene as PNG', () => this.savePicture());
    this.note = element('span', {class: 'soft', role: 'status'});
    this.picked = element('p', {class: 'soft', role: 'status'}, 'Click a landmark in the scene or in an image to identify it.');
    this.moments = element('nav', {'aria-label': 'moments'});
    this.strips = element('div', {class: 'strips'});
    this.stripNames = element('p', {class: 'key'});
    this.inCommon = several ? element('p', {class: 'soft', role: 'status'}) : null;
    this.split = several ? button('split', 'v: one view per run, moved together', () => this.setSplit(!this.scene.isSplit)) : null;
    this.timeLine = element('div', {class: 'timeline'});
    document.body.append(
      element('header', {}, element('h1', {}, this.live ? 'GaitSLAM, live' : 'GaitSLAM, playback'), element('b', {}, this.title), this.note),
      element('main', {},
        element('div', {class: `views${several ? ' several' : ''}`},
          several ? this.table() : null,
          element('figure', {class: 'space'}, this.scene.element, this.legend(), this.picked, this.inCommon),
          element('figure', {class: `head heads-${this.panes.filter(({first}) => !first).length}`}, this.panes.map((pane) => pane.element), searchLegend(this.panes[0].shared.length > 1))),
        element('div', {class: 'rig'}, this.rig.map((layer) => layer.element)),
        this.stripNames, this.strips),
      element('footer', {}, this.timeLine, element('div', {class: 'controls'}, this.play, this.slider, this.clock, this.step, this.speeds, this.views, this.split, this.save), this.moments));
    this.speeds.value = this.live ? 0 : 1;
    if (this.live) this.speeds.disabled = this.step.disabled = !this.about.control;
    if (this.live && !this.about.control) this.speeds.title = this.step.title = 'read-only; start the run with --control';
    document.title = `GaitSLAM: ${[this.title, ...this.panes.map(({full}) => full)].filter(Boolean).join(' | ')}`;
    this.sayPlay();
    this.listMoments();
  }

  get title() {
    const [{label, scenario, seed}] = this.about.runs;
    if (this.panes.length === 1) return label;
    return this.about.runs.every((run) => run.seed === seed) ? `${scenario}, seed ${seed}` : scenario;
  }

  legend() {
    const layer = (name, role, text) => this.button(text, 'show or hide', (pressed) => this.setLayer(name, pressed.getAttribute('aria-pressed') !== 'true'),
      {'data-layer': name, 'aria-pressed': 'true', class: `layer role-${role}`});
    const several = this.panes.length > 1;
    return element('p', {class: 'key'}, layer('truth', 'truth', '— true'), layer('plan', 'plan', '— planned'), layer('steps', 'landed', '▭ steps'),
      this.panes.flatMap(({name, role}, i) => [layer(`estimate${i}`, role, several ? `— ${name}` : '— estimated'),
        layer(`map${i}`, several ? role : 'first', several ? `● landmarks of ${name}` : '● landmarks, 3σ')]), ' camera’s own 3σ enlarged ten times');
  }

  /// Describes a landmark and highlights it in the scene and the image; null: none.
  pick(landmark) {
    this.landmark = landmark;
    this.sayLandmark();
  }

  sayLandmark() {
    const {run, id} = this.landmark ?? {}, map = ({run: of, index}) => of.mapAt(index), own = this.panes[run];
    this.scene.showPicked(this.landmark ?? null);
    const texts = this.panes.map((pane, k) => {
      const same = own && (k === run ? id : matched(map(own), map(pane)).get(id));
      pane.mark(same ?? null);
      return same === undefined ? '' : `${pane.name ? `${pane.name}: ` : ''}${pane.run.landmarkText(pane.index, same)}`;
    });
    if (own) this.picked.textContent = texts.filter(Boolean).join(' · at the same place: ');
  }

  sayInCommon() {
    const [a, b] = this.panes.map(({run, index}) => run.mapAt(index)), count = matched(a, b).size, [p, q] = this.panes;
    this.inCommon.textContent = `Landmarks matched by place (nearest to each other, within 0.1 m): ${count} in both, ${a.length - count} only in ${p.name}, ${b.length - count} only in ${q.name}.`;
  }

  setSplit(isSplit) {
    this.scene.setSplit(isSplit);
    this.split?.setAttribute('aria-pressed', Boolean(this.scene.isSplit));
    this.writeHash();
  }

  savePicture() {
    this.scene.render();
    this.scene.renderer?.domElement.toBlob((blob) => {
      const link = element('a', {href: URL.createObjectURL(blob), download: `gaitslam-${this.t.toFixed(2)}s.png`});
      link.click();
      URL.revokeObjectURL(link.href);
    });
  }

  setLayer(name, on) {
    this.scene.hidden[on ? 'delete' : 'add'](name);
    document.querySelector(`[data-layer=${name}]`)?.setAttribute('aria-pressed', on);
    this.show(this.t);
    this.writeHash();
  }

  /// The differences between the runs, as sent by the program; clicking a row's first cell goes to its worst instant.
  table() {
    const {titles, rows} = this.about.changes, role = (i) => (this.panes[i - 1] ? `role-${this.panes[i - 1].role}` : '');
    const first = (text, t) => (t === null ? text : this.button(text, 'go to its worst instant', () => this.go(t)));
    const ofKey = ([key, ...values]) => [element('td', {}, key), element('td', {colspan: titles.length - 1},
      this.panes.map(({name}, i) => element('div', {class: role(i + 1)}, `${name}: ${values[i]}`)))];
    const table = element('table', {}, element('thead', {}, element('tr', {}, titles.map((title, i) => element('th', {class: role(i), scope: 'col'}, title)))),
      element('tbody', {}, rows.map(({key, cells, remark, t}) => element('tr', {title: remark},
        key ? ofKey(cells) : cells.map((text, i) => element('td', {class: role(i)}, i ? text : first(text, t)))))));
    sortable(table);
    return element('section', {class: 'changes scroll', tabindex: 0, 'aria-label': 'what differs between the runs'}, table);
  }

  listMoments() {
    const ofRuns = new Map();  // events that several runs have at the same time are one mark, without names if all have it
    for (const {name, run} of this.panes) {
      for (const moment of run.about.moments) {
        const key = `${moment.t.toFixed(1)} ${moment.text}`, names = [...ofRuns.get(key)?.names ?? [], name].filter(Boolean);
        ofRuns.set(key, {...moment, names, text: [0, this.panes.length].includes(names.length) ? moment.text : `${names.join(', ')}: ${moment.text}`});
      }
    }
    const all = [...this.marks, ...ofRuns.values()].sort((a, b) => a.t - b.t), say = ({t, text}) => `${t.toFixed(1)} s ${text}`;
    this.jumps = all.map(({t}) => t);
    this.moments.replaceChildren(...all.map((mark) => this.button(say(mark), `${say(mark)} ([ and ]: previous and next)`, () => this.go(mark.t), {class: `moment ${mark.kind}`})));
    return all;
  }

  /// step > 0: jumps to the next moment; otherwise to the previous one.
  jump(step) {
    const near = 0.005, next = step > 0 ? this.jumps.find((t) => t > this.t + near) : this.jumps.filter((t) => t < this.t - near).at(-1);
    if (next !== undefined) this.go(next);
  }

  drawFigures(isAsked = false) {
    const runs = this.panes.filter(({series}) => series), marks = this.listMoments(), names = known(runs), zoomed = this.figures[0]?.range, focus = this.timeLine.matches(':hover') || this.strips.matches(':hover');
    if (!runs.length || (focus && !isAsked)) return;  // a figure under the mouse is not redrawn
    this.stripNames.replaceChildren('Figures: ', ...names.map((name) => this.button(name.replaceAll('_', ' '), 'show or hide', () => this.toggleStrip(name),
      {'data-strip': name, 'aria-pressed': String(!this.hiddenStrips.has(name)), class: 'layer'})));
    this.width = innerWidth;
    const line = timeLine(runs, marks, Math.max(320, innerWidth - 28)), strips = figures(runs, marks, this.hiddenStrips);
    this.figures = [...(line ? [line] : []), ...strips];
    this.timeLine.replaceChildren(...(line ? [line.holder] : []));
    this.strips.replaceChildren(...strips.map(({holder}) => holder));
    follow(this.figures, (t, goesOn) => this.go(t, goesOn), () => this.showCursor(), () => this.writeHash(), true);
    if (zoomed && !this.live) for (const figure of this.figures) figure.zoom(...zoomed);
    this.showCursor();
  }

  toggleStrip(name) {
    if (!this.hiddenStrips.delete(name)) this.hiddenStrips.add(name);
    this.drawFigures(true);
    this.writeHash();
  }

  showCursor() { for (const figure of this.figures) figure.show(this.t); }

  get duration() { return Math.max(...this.panes.map((pane) => pane.run.duration)); }

  show(t) {
    this.t = t;
    for (const pane of this.panes) pane.show(Math.max(0, pane.run.indexAt(t)), t);
    const {index} = this.panes[0];
    this.scene.show(Math.max(0, index));
    for (const layer of this.rig) layer.show(index);
    if (this.landmark) this.sayLandmark();
    if (this.inCommon) this.sayInCommon();
    this.showCursor();
    this.slider.max = this.duration;
    this.slider.value = t;
    this.clock.textContent = `${t.toFixed(2)} s`;
  }

  go(t, goesOn = false) {
    if (!Number.isFinite(t)) return;
    this.atEnd = false;  // looking back affects only this viewer
    if (this.playing && !this.live) this.pause();
    if (this.live) this.sayPlay();
    this.show(Math.min(Math.max(t, 0), this.duration));
    if (!goesOn) this.writeHash();
  }

  /// Writes time, view, hidden layers and zoom to the URL, at most four times per second, because browsers ignore more frequent changes.
  writeHash() {
    this.hashTimer ??= setTimeout(() => this.writeHashNow(), 250);
  }

  writeHashNow() {
    this.hashTimer = null;
    const {hidden} = this.scene, [figure] = this.figures, values = {t: this.t.toFixed(2), view: this.mode === 'follow' ? '' : this.mode,
      hide: [...hidden].join(','), strips: [...this.hiddenStrips].join(','), split: this.scene.isSplit ? 'yes' : '', zoom: figure?.isZoomed ? figure.range.map((v) => v.toFixed(2)).join(',') : ''};
    history.replaceState(null, '', `#${Object.entries(values).filter(([, value]) => value).map(([name, value]) => `${name}=${value}`).join('&')}`);
  }

  goToHash() {
    const values = new URLSearchParams(location.hash.slice(1)), t = parseFloat(values.get('t')), zoom = (values.get('zoom') ?? '').split(',').map(Number);
    const names = (values.get('hide') ?? '').split(',').filter((name) => this.scene.layers[name]), view = values.get('view');
    for (const name of names) this.setLayer(name, false);
    if (values.get('split')) this.setSplit(true);
    if (values.has('t')) {
      this.hiddenStrips = new Set((values.get('strips') ?? '').split(','));
      this.drawFigures();
    }
    if (['orbit', 'head'].includes(view)) this.setMode(view);
    if (zoom.length === 2 && zoom[0] < zoom[1]) for (const figure of this.figures) figure.zoom(...zoom);
    if (Number.isFinite(t)) this.go(t);
    return Number.isFinite(t);
  }

  toggle() {
    if (this.playing && (this.atEnd || !this.live)) this.pause();
    else this.resume();
  }

  pause() {
    this.playing = false;
    if (this.live && this.about.control) this.send({op: 'pause'});
    else this.atEnd = !this.live;
    this.sayPlay();
  }

  resume() {
    const goesOn = this.playing;
    this.playing = this.atEnd = true;
    if (this.live) {
      if (this.about.control && !goesOn) this.send({op: 'resume'});
      this.show(this.duration);
    } else {
      if (this.t >= this.duration) this.show(0);
      this.playSince = undefined;
      requestAnimationFrame((now) => this.tick(now));
    }
    this.sayPlay();
  }

  sayPlay() {
    const [pause, go] = this.live && !this.about.control ? ['freeze the view', 'newest'] : ['pause', 'play'];
    this.play.textContent = this.live && !this.atEnd ? 'newest' : this.playing ? pause : go;
    dataset.playing = this.playing;
  }

  tick(now) {
    if (!this.playing) return;
    const {run} = this.panes[0], passed = (now - (this.playSince ?? now)) / 1000;
    this.playSince = now;
    const next = this.speed > 0 ? this.t + this.speed * passed : run.frames[Math.min(run.frames.length - 1, Math.max(0, run.indexAt(this.t)) + kFast)].t;
    this.show(Math.min(next, this.duration));
    if (this.t >= this.duration) this.pause();
    else requestAnimationFrame((later) => this.tick(later));
  }

  /// frames > 0: forward; < 0: back.
  stepBy(frames) {
    const {run} = this.panes[0], index = Math.max(0, run.indexAt(this.t)) + frames;
    this.go(run.frames[Math.min(Math.max(index, 0), run.frames.length - 1)]?.t);
  }

  stepOn() {
    if (!this.live) return this.stepBy(1);
    if (!this.about.control) return undefined;
    this.playing = false;
    this.atEnd = true;
    this.send({op: 'step'});
    return this.sayPlay();
  }

  setSpeed(speed) {
    this.speed = speed;
    this.speeds.value = speed;
    if (this.live) this.send({op: 'speed', factor: speed});
  }

  setMode(mode) {
    this.views.value = this.mode = mode;
    this.scene.setMode(mode, Math.max(0, this.panes[0].index));
    if (mode === 'head') this.note.textContent = 'The scene is drawn without the lens distortion that the image next to it has.';
    if (dataset.ready) this.writeHash();
  }

  key(event) {
    const {tagName, type} = event.target, presses = tagName === 'BUTTON' || tagName === 'SUMMARY' || type === 'checkbox';
    if (event.ctrlKey || event.altKey || event.metaKey || tagName === 'SELECT' || (presses && [' ', 'Enter'].includes(event.key))) return;
    const action = {' ': () => this.toggle(), '.': () => this.stepOn(), ',': () => this.stepBy(-1), ArrowRight: () => this.stepBy(event.shiftKey ? 30 : 1),
      ArrowLeft: () => this.stepBy(event.shiftKey ? -30 : -1), Home: () => this.go(0), End: () => (this.live ? this.resume() : this.go(this.duration)),
      f: () => this.speeds.disabled || this.setSpeed(0), 1: () => this.speeds.disabled || this.setSpeed(1), 4: () => this.speeds.disabled || this.setSpeed(0.25),
      '?': () => { this.note.textContent = kKeys; }, '[': () => this.jump(-1), ']': () => this.jump(1), r: () => this.setMode('follow'), o: () => this.setMode('orbit'), c: () => this.setMode('head'), s: () => this.savePicture(), v: () => this.setSplit(!this.scene.isSplit)}[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  /// Frames arrive in pieces of some seconds, in order; the time in the URL is shown as soon as its frames are available. The first picture
  /// is drawn only once, when it is complete, because every drawing of the scene or of a figure delays the next one.
  async playBack(begin, model) {
    const images = this.panes.filter(({first, run}) => !first && run.about.camera).map((pane) => pane.images.at(0).catch(() => null));
    const wanted = parseFloat(new URLSearchParams(location.hash.slice(1)).get('t'));
    let isThere = false, pictures = null;
    for (let piece = 0; this.panes.some(({run}) => piece < run.about.pieces); ++piece) {
      await Promise.all(this.panes.map(async ({run}, i) => {
        if (piece < run.about.pieces) for (const frame of await (piece === 0 ? begin[i].frames : getJson(`/frames/${i}/${piece}`))) run.append(frame);
      }));
      if (piece === 0) {
        await Promise.all(images);
        this.addModel(await model);
        await drawnOnce();
        pictures = this.loadPictures();
        await Promise.all(this.panes.map(async (pane, i) => { pane.series = Series.of(await begin[i].series); }));
        this.drawFigures();
      }
      if (!isThere && this.t === 0 && wanted <= this.duration) isThere = this.goToHash();
    }
    if (this.panes.length > 1) {
      this.marks = partings(this.panes);
      this.drawFigures();
    }
    if (!isThere && this.t === 0) this.goToHash();
    this.show(this.t);
    dataset.ready = 'true';
    await pictures;
  }

  addModel(model) {
    if (model) this.scene.addModel(model);
    this.show(this.t);
  }

  /// Loads the room's textures, for which the first picture of the scene does not wait.
  async loadPictures() {
    await Promise.all(Object.keys(this.scene.surfaces).map(async (number) => {
      let painted = await getBlob(`/picture/0/${number}`);
      while (painted.size === 0) {  // still being painted
        await new Promise((resolve) => setTimeout(resolve, 100));
        painted = await getBlob(`/picture/0/${number}`);
      }
      this.scene.addPicture(number, await picture(painted));
    }));
    this.scene.draw();
  }

  followLive() {
    const [pane] = this.panes;
    let drawing = false;
    this.send = listen({
      frame: (frame, image) => {
        if (!pane.run.append(frame)) return;
        if (frame.image) pane.keep(pane.run.frames.length - 1, image, frame.image);
        dataset.ready = 'true';
        if (!this.atEnd || drawing) return;
        drawing = true;
        requestAnimationFrame(() => {
          drawing = false;
          if (this.atEnd) this.show(this.duration);
        });
      },
      message: (message) => this.receive(message),
      closed: () => { if (!this.ended) this.note.textContent = 'The connection was closed because the run or its program has ended.'; },
    });
  }

  receive({op, paused, speed, how, why, names, from, rows, frames}) {
    const [{run}] = this.panes;
    if (op === 'past') {
      for (const frame of frames) run.append(frame);
    } else if (op === 'series') {
      this.panes[0].series ??= new Series(names);
      this.panes[0].series.add(from, rows);
      this.drawFigures();
    } else if (op === 'pace') {
      this.playing = this.about.control ? !paused : this.playing;
      if (this.about.control) this.speeds.value = speed;
      this.sayPlay();
    } else if (op === 'ended') {
      this.ended = true;
      dataset.ended = 'true';
      this.note.textContent = run.frames.length < frames ? `${how} This page received ${run.frames.length} of ${frames} frames.` : how;
      this.live = this.playing = this.speeds.disabled = this.step.disabled = false;  // what was received can be played
      this.setSpeed(1);
      this.drawFigures();
      this.sayPlay();
    } else if (op === 'rejected') {
      this.note.textContent = why;
    }
  }
}

async function start() {
  try {
    const about = await getJson('/about'), {runs} = about;
    // Fetched while the page is being built, which takes longer.
    const model = runs[0].has_model ? getBytes('/model/0') : null;
    const begin = about.mode === 'live' ? [] : runs.map((_, i) => ({series: getBytes(`/series/${i}`), frames: getJson(`/frames/${i}/0`)}));
    const page = new Page(about);
    globalThis.gaitslamPage = page;
    if (page.live) {
      page.followLive();
      try {
        page.addModel(await model);
        await drawnOnce();
        await page.loadPictures();
      } finally {
        page.send({op: 'loaded'});
      }
    } else {
      await page.playBack(begin, model);
    }
    dataset.model = 'true';
  } catch (error) {
    document.body.append(element('p', {class: 'note'}, error.message));
  }
}

start();
