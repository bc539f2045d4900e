// The page: one scene and one timeline for all runs, the images of each run, time plots, and keyboard
// control.
import {button, element} from '../../pages/web/dom.js';
import {addressWriter, readAddress} from './address.js';
import {save, saveClip} from './clip.js';
import {partings, whyWorse} from './compare.js';
import {Landmarks} from './landmarks.js';
import {build, controls} from './layout.js';
import {followLive} from './live.js';
import {Moments} from './moments.js';
import {Pane} from './pane.js';
import {firstFiles, playBack} from './playback.js';
import {Player} from './player.js';
import {Plots} from './plots.js';
import {Run} from './run.js';
import {Scene} from './scene.js';
import {RigLayer} from './sensors.js';
import {getBytes, getJson, pause} from './source.js';

const kRoles = ['estimate', 'second', 'third', 'first']; // roles of the runs
const kLetters = 'ABCD'; // names of the runs if there are several
const kReading_ms = 50;
const kBefore_s = 3; // start of a clip before the instant that it shows
const kPerSecond = 30; // frames that an arrow with shift moves
const kKeys =
  'space: play or pause · arrows, . and ,: one frame, with shift one second · [ and ]: previous and next ' +
  'mark · home, end · f, 1, 4: speed · r, o, c: follow, stay, through the camera · v: one view per run · ' +
  'i: images as the filter got them or as recorded · s: save the scene as PNG · in a figure: click or drag to go to a time, wheel to zoom (above the ' +
  'timeline: Ctrl and wheel), double-click to show everything, click a name in a legend to hide its line';

/// The seed and the variant that distinguish each run from the others.
function differencesOf(runs) {
  const differ = (key) => new Set(runs.map((run) => run[key])).size > 1;
  const words = (run) => [differ('seed') && `seed ${run.seed}`, differ('variant') && run.variant];
  return runs.map((run) => words(run).filter(Boolean).join(', '));
}

function panesOf(runs) {
  const differences = differencesOf(runs),
    panes = [];
  runs.forEach((about, i) => {
    const name = runs.length > 1 ? kLetters[i] : '',
      {recording, seen} = about,
      hasSame = ({run, first}) => !first && run.about.recording === recording && run.about.seen === seen,
      first = recording ? panes.find(hasSame) : null;
    panes.push(new Pane(new Run(about, i), name, differences[i], kRoles[i], first));
  });
  return panes;
}

class Page {
  constructor(about) {
    this.about = about;
    this.dataset = document.documentElement.dataset;
    this.mode = 'follow';
    this.isSeen = true;
    this.panes = panesOf(about.runs);
    const [{run}] = this.panes;
    this.player = new Player(
      this.panes,
      {live: about.mode === 'live', control: about.control},
      {
        show: (t) => this.show(t),
        said: () => this.sayPlay(),
        moved: () => this.writeAddress()
      }
    );
    this.scene = new Scene(run, this.panes.slice(1));
    this.landmarks = new Landmarks(this.panes, this.scene, () => this.writeAddress());
    this.rig = run.about.rig.flatMap((sensor, i) =>
      sensor.kind === 'imu' ? [] : [new RigLayer(run, sensor, i, this.scene)]
    );
    this.moments = new Moments(this.panes, (t) => this.player.go(t));
    this.plots = new Plots(this.panes, this.player, {
      go: (t, goesOn) => this.player.go(t, goesOn),
      changed: () => this.writeAddress()
    });
    this.note = element('span', {class: 'soft', role: 'status'});
    this.why = element('p', {role: 'status'});
    this.controls = controls(this);
    this.writeAddress = addressWriter(() => this.addressValues());
    build(this);
    this.sayPlay();
    addEventListener('keydown', (event) => this.press(event));
    addEventListener('hashchange', () => this.goToAddress());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
      this.scene.paint();
      this.player.show(this.player.t);
    });
  }

  show(t) {
    for (const pane of this.panes) pane.show(Math.max(0, pane.run.indexAt(t)), t);
    const [{index}] = this.panes,
      {slider, clock} = this.controls;
    this.scene.show(Math.max(0, index));
    for (const layer of this.rig) layer.show(index);
    this.landmarks.show();
    this.plots.show();
    slider.max = this.player.duration;
    slider.value = t;
    clock.textContent = `${t.toFixed(2)} s`;
  }

  sayPlay() {
    const {live, control, atEnd, playing} = this.player;
    const [stop, go] = live && !control ? ['freeze the view', 'newest'] : ['pause', 'play'];
    this.controls.play.textContent = live && !atEnd ? 'newest' : playing ? stop : go;
    this.dataset.playing = playing;
    this.plots.show();
  }

  drawFigures() {
    this.moments.list();
    this.plots.draw({marks: this.moments.marks, keepsZoom: !this.player.live});
  }

  /// Marks where the first two runs differ, and states why one is worse.
  addPartings() {
    this.moments.partings = partings(this.panes);
    this.drawFigures();
    const why = whyWorse(this.panes, this.moments.partings);
    if (!why) return;
    const from = Math.max(0, why.t - kBefore_s);
    this.why.replaceChildren(
      why.text,
      ' ',
      button('go there', 'show this time', () => this.player.go(why.t)),
      ' ',
      button('save 10 s as video', 'plays 10 s and saves them as WebM', () => saveClip(this, from))
    );
  }

  addModel(model) {
    if (model) this.scene.addModel(model);
    this.player.show(this.player.t);
  }

  setLayer(name, on) {
    this.scene.hidden[on ? 'delete' : 'add'](name);
    document.querySelector(`[data-layer=${name}]`)?.setAttribute('aria-pressed', on);
    this.player.show(this.player.t);
    this.writeAddress();
  }

  setEnded(how) {
    this.dataset.ended = 'true';
    this.note.textContent = how;
  }

  setSpeed(speed) {
    if (this.controls.speeds.disabled) return;
    this.controls.speeds.value = speed;
    this.player.setSpeed(speed);
  }

  setMode(mode) {
    this.controls.views.value = this.mode = mode;
    this.scene.setMode(mode, Math.max(0, this.panes[0].index));
    if (mode === 'head')
      this.note.textContent = 'The scene is drawn without the lens distortion that the image next to it has.';
    if (this.dataset.ready) this.writeAddress();
  }

  setSplit(isSplit) {
    this.scene.setSplit(isSplit);
    this.controls.split?.setAttribute('aria-pressed', Boolean(this.scene.isSplit));
    this.writeAddress();
  }

  /// Shows the images as the filter got them, or as recorded.
  setSeen(isSeen) {
    this.isSeen = isSeen;
    this.controls.seen.value = isSeen ? 'seen' : 'recorded';
    for (const pane of this.panes) pane.setSeen(isSeen);
    this.writeAddress();
  }

  savePicture() {
    this.scene.render();
    this.scene.renderer?.domElement.toBlob((blob) => save(blob, `gaitslam-${this.player.t.toFixed(2)}s.png`));
  }

  addressValues() {
    const {hidden, isSplit, optional} = this.scene,
      [figure] = this.plots.figures;
    return {
      t: this.player.t.toFixed(2),
      view: this.mode === 'follow' ? '' : this.mode,
      hide: [...hidden].filter((name) => !optional.includes(name)).join(','),
      show: optional.filter((name) => !hidden.has(name)).join(','),
      strips: [...this.plots.hidden].join(','),
      image: this.isSeen ? '' : 'recorded',
      pick: this.landmarks.picked ? `${this.landmarks.picked.run}.${this.landmarks.picked.id}` : '',
      split: isSplit ? 'yes' : '',
      zoom: figure?.isZoomed ? figure.range.map((v) => v.toFixed(2)).join(',') : ''
    };
  }

  /// Applies the contents of the URL. Returns whether it has a time.
  goToAddress() {
    const {t, view, hide, show, strips, split, zoom, image, pick} = readAddress();
    for (const name of hide) if (this.scene.layers[name]) this.setLayer(name, false);
    for (const name of show) if (this.scene.layers[name]) this.setLayer(name, true);
    if (split) this.setSplit(true);
    if (strips) {
      this.plots.hidden = new Set(strips);
      this.drawFigures();
    }
    if (['orbit', 'head'].includes(view)) this.setMode(view);
    if (zoom) this.plots.zoom(...zoom);
    if (image === 'recorded') this.setSeen(false);
    if (this.panes[pick?.run]) this.landmarks.pick(pick);
    this.player.go(t);
    return Number.isFinite(t);
  }

  /// Returns the action of a key, if any.
  actionOf({key, shiftKey}) {
    const {player, moments} = this,
      frames = shiftKey ? kPerSecond : 1;
    return {
      ' ': () => player.toggle(),
      '.': () => player.step(),
      ',': () => player.stepBy(-1),
      ArrowRight: () => player.stepBy(frames),
      ArrowLeft: () => player.stepBy(-frames),
      Home: () => player.go(0),
      End: () => (player.live ? player.resume() : player.go(player.duration)),
      '[': () => moments.jump(player.t, -1),
      ']': () => moments.jump(player.t, 1),
      f: () => this.setSpeed(0),
      1: () => this.setSpeed(1),
      4: () => this.setSpeed(0.25),
      r: () => this.setMode('follow'),
      o: () => this.setMode('orbit'),
      c: () => this.setMode('head'),
      s: () => this.savePicture(),
      i: () => this.setSeen(!this.isSeen),
      v: () => this.setSplit(!this.scene.isSplit),
      '?': () => {
        this.note.textContent = kKeys;
      }
    }[key];
  }

  press(event) {
    const {tagName, type} = event.target;
    const isPressed = tagName === 'BUTTON' || tagName === 'SUMMARY' || type === 'checkbox';
    const isOther = event.ctrlKey || event.altKey || event.metaKey || tagName === 'SELECT';
    const action = this.actionOf(event);
    if (!action || isOther || (isPressed && event.key === ' ')) return;
    event.preventDefault();
    action();
  }
}

/// Waits until the program has read the results.
async function aboutResults() {
  const note = element('p', {class: 'note'}, 'Reading the results …');
  let about = await getJson('/about');
  for (; about.mode === 'reading'; about = await getJson('/about')) {
    document.body.append(note);
    await pause(kReading_ms);
  }
  note.remove();
  return about;
}

async function start() {
  try {
    const about = await aboutResults(),
      {runs} = about;
    // Fetched while the page is being built, which takes longer.
    const model = runs[0].has_model ? getBytes('/model/0') : null;
    const first = about.mode === 'live' ? null : firstFiles(runs);
    const page = new Page(about);
    globalThis.gaitslamPage = page; // for tests
    if (about.how) page.setEnded(about.how);
    await (first ? playBack(page, first, model) : followLive(page, model));
    page.dataset.model = 'true';
  } catch (error) {
    document.body.append(element('p', {class: 'note'}, error.message));
  }
}

start();
