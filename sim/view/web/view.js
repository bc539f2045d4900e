// The page: panes of one run or two, the time line that they share, and the keys.
import {element} from '../../pages/web/dom.js';
import {Run} from '../../pages/web/run.js';
import {Pane} from './pane.js';
import {getJson, listen} from './source.js';

const {dataset} = document.documentElement;
const kFast = 5;  // frames of a finished run for each that the browser draws

class Page {
  constructor(about) {
    Object.assign(this, {about, live: about.mode === 'live', t: 0, playing: about.mode === 'live', speed: 1, mode: 'follow', atEnd: true});
    this.panes = about.runs.map((run, i) => new Pane(new Run(run, i), (t) => this.go(t)));
    this.build();
    addEventListener('keydown', (event) => this.key(event));
    addEventListener('hashchange', () => this.goToHash());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.panes.forEach((pane) => pane.repaint()));
  }

  build() {
    const button = (text, title, action) => element('button', {type: 'button', title, onclick: action}, text);
    this.play = button('', 'space', () => this.toggle());
    this.step = button('step', 'one frame: .', () => this.stepOn());
    this.speeds = element('select', {'aria-label': 'speed', title: 'f: full speed, 1, 4: a quarter', onchange: () => this.setSpeed(+this.speeds.value)},
      [[0, 'full speed'], [1, '1 ×'], [0.25, '0.25 ×']].map(([value, text]) => element('option', {value}, text)));
    this.views = element('select', {'aria-label': 'view', title: 'r, o, c', onchange: () => this.setMode(this.views.value)},
      [['follow', 'follow the robot'], ['orbit', 'stay'], ['head', 'through the camera']].map(([value, text]) => element('option', {value}, text)));
    this.slider = element('input', {type: 'range', min: 0, max: 1, step: 0.001, value: 0, 'aria-label': 'time', oninput: () => this.go(+this.slider.value)});
    this.clock = element('output', {}, '0.00 s');
    this.note = element('span', {class: 'soft', role: 'status'});
    this.moments = element('nav', {'aria-label': 'moments'});
    document.body.append(
      element('header', {}, element('h1', {}, this.live ? 'GaitSLAM, live' : 'GaitSLAM, playback'), this.note),
      element('main', {class: `panes-${this.panes.length}`}, this.panes.map((pane) => pane.element)),
      element('footer', {}, element('div', {class: 'controls'}, this.play, this.step, this.speeds, this.views, this.slider, this.clock), this.moments));
    this.speeds.value = this.live ? 0 : 1;
    if (this.live) this.speeds.disabled = this.step.disabled = !this.about.control;
    if (this.live && !this.about.control) this.speeds.title = this.step.title = 'read-only: start the run with --control';
    document.title = `GaitSLAM: ${this.panes.map((pane) => pane.run.about.label).join(' | ')}`;
    this.sayPlay();
    this.listMoments();
  }

  listMoments() {
    const all = this.panes.flatMap((pane) => pane.run.about.moments.map((moment) => ({...moment,
      where: this.panes.length > 1 ? `${pane.run.about.label}: ` : ''})));
    this.moments.replaceChildren(...all.map(({t, kind, text, where}) => element('button', {type: 'button', class: `moment ${kind}`,
      onclick: () => this.go(t)}, `${t.toFixed(1)} s ${where}${text}`)));
  }

  get duration() { return Math.max(...this.panes.map((pane) => pane.run.duration)); }

  /// Shows the frames of a time in all panes.
  show(t) {
    this.t = t;
    for (const pane of this.panes) pane.show(Math.max(0, pane.run.indexAt(t)));
    this.slider.max = this.duration;
    this.slider.value = t;
    this.clock.textContent = `${t.toFixed(2)} s`;
    dataset.t = t;
  }

  /// Goes to a chosen time.
  go(t) {
    if (!Number.isFinite(t)) return;
    this.atEnd = false;
    if (this.playing) this.pause();
    this.show(Math.min(Math.max(t, 0), this.duration));
    history.replaceState(null, '', `#t=${this.t.toFixed(2)}`);
  }

  goToHash() {
    const t = /^#t=([0-9.]+)$/.exec(location.hash)?.[1];
    if (t !== undefined) this.go(+t);
    return t !== undefined;
  }

  toggle() { if (this.playing) this.pause(); else this.resume(); }

  pause() {
    this.playing = false;
    if (this.live && this.about.control) this.send({op: 'pause'});
    this.sayPlay();
  }

  resume() {
    this.playing = this.atEnd = true;
    if (this.live) {
      if (this.about.control) this.send({op: 'resume'});
      this.show(this.duration);
    } else {
      if (this.t >= this.duration) this.show(0);
      this.playSince = undefined;
      requestAnimationFrame((now) => this.tick(now));
    }
    this.sayPlay();
  }

  sayPlay() {
    const [pause, go] = this.live && !this.about.control ? ['hold the view', 'newest'] : ['pause', 'play'];
    this.play.textContent = this.playing ? pause : go;
    dataset.playing = this.playing;
  }

  /// Plays a finished run.
  tick(now) {
    if (!this.playing) return;
    const {run} = this.panes[0], passed = (now - (this.playSince ?? now)) / 1000;
    this.playSince = now;
    const next = this.speed > 0 ? this.t + this.speed * passed : run.frames[Math.min(run.frames.length - 1, Math.max(0, run.indexAt(this.t)) + kFast)].t;
    this.show(Math.min(next, this.duration));
    if (this.t >= this.duration) this.pause();
    else requestAnimationFrame((later) => this.tick(later));
  }

  /// frames > 0: on, < 0: back.
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
    for (const pane of this.panes) pane.scene?.setMode(mode, Math.max(0, pane.index));
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || ['SELECT', 'INPUT', 'BUTTON'].includes(event.target.tagName)) return;
    const action = {' ': () => this.toggle(), '.': () => this.stepOn(), ',': () => this.stepBy(-1), ArrowRight: () => this.stepBy(event.shiftKey ? 30 : 1),
      ArrowLeft: () => this.stepBy(event.shiftKey ? -30 : -1), Home: () => this.go(0), End: () => (this.live ? this.resume() : this.go(this.duration)),
      f: () => this.speeds.disabled || this.setSpeed(0), 1: () => this.speeds.disabled || this.setSpeed(1), 4: () => this.speeds.disabled || this.setSpeed(0.25),
      r: () => this.setMode('follow'), o: () => this.setMode('orbit'), c: () => this.setMode('head')}[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  async playBack() {
    await Promise.all(this.panes.map(async (pane) => {
      const {frames, strips} = await getJson(`/run/${pane.run.index}`);
      for (const frame of frames) pane.run.append(frame);
      pane.showStrips(strips);
    }));
    if (!this.goToHash()) this.show(0);
    dataset.frames = this.panes[0].run.frames.length;
    dataset.ready = 'true';
  }

  followLive() {
    const [pane] = this.panes;
    let drawing = false;
    this.send = listen({
      frame: (frame, image) => {
        if (!pane.run.append(frame)) return;
        if (frame.image) pane.keep(pane.run.frames.length - 1, image, frame.image);
        dataset.frames = pane.run.frames.length;
        dataset.ready = 'true';
        if (!this.atEnd || drawing) return;
        drawing = true;
        requestAnimationFrame(() => {
          drawing = false;
          this.show(this.duration);
        });
      },
      message: (message) => this.receive(message),
      closed: () => this.closed(),
    });
  }

  closed() {
    dataset.closed = 'true';
    if (!this.ended) this.note.textContent = 'The connection is closed: the run or its program has ended.';
  }

  receive({op, paused, speed, how, why, html}) {
    if (op === 'strips') {
      this.panes[0].showStrips(html);
    } else if (op === 'pace') {
      this.playing = this.about.control ? !paused : this.playing;
      if (this.about.control) this.speeds.value = speed;
      this.sayPlay();
    } else if (op === 'ended') {
      this.ended = true;
      dataset.ended = 'true';
      this.note.textContent = how;
    } else if (op === 'rejected') {
      this.note.textContent = why;
    }
  }
}

async function start() {
  try {
    const page = new Page(await getJson('/about'));
    globalThis.gaitslamPage = page;
    if (page.live) page.followLive();
    else await page.playBack();
    await Promise.all(page.panes.map((pane) => pane.loadModel())).finally(() => page.live && page.send({op: 'loaded'}));
    dataset.model = 'true';
  } catch (error) {
    document.body.append(element('p', {class: 'note'}, error.message));
  }
}

start();
