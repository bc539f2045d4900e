// One run: three dimensions, head image, state in words, figures over time.
import {element} from '../../pages/web/dom.js';
import {Figure, follow} from '../../pages/web/figures.js';
import {kOutcomes} from '../../pages/web/run.js';
import {Scene} from '../../pages/web/scene.js';
import {HeadView, RigLayer, grayPicture} from './sensors.js';
import {Stored, getBytes, picture} from './source.js';

const legend = () => element('p', {class: 'key'},
  element('b', {class: 'truth'}, '— true'), element('b', {class: 'plan'}, '— planned'), element('b', {class: 'estimate'}, '— estimated'),
  element('b', {class: 'landed'}, '▭ landed'), element('b', {class: 'first'}, '● landmarks, 3σ'), ' camera’s own 3σ ten times as large');
const kSigns = {found: '◯▫', missed: '◌', rejected: '◯×'};
const searchLegend = () => element('p', {class: 'key'}, 'searched, 3σ: ',
  ...Object.keys(kOutcomes).map((outcome) => element('b', {class: outcome}, `${kSigns[outcome]} ${outcome}`)), element('b', {class: 'new'}, '▫ new'));

export class Pane {
  constructor(run, go) {
    Object.assign(this, {run, go, index: -1, figures: []});
    this.images = new Stored(`/rig/${run.index}/${run.about.rig.length}`, picture, 400);
    this.live = new Map();
    this.head = new HeadView(run);
    this.state = element('p', {class: 'state', role: 'status'});
    this.counts = element('p', {class: 'soft'});
    this.strips = element('div', {class: 'strips'});
    try {
      this.scene = new Scene(run);
    } catch (error) {
      this.failure = `Three dimensions cannot be drawn here: ${error.message}`;
    }
    this.rig = run.about.rig.map((sensor, i) => new RigLayer(run, sensor, i, this.scene)).filter(({isShown}) => isShown);
    const notes = [...run.about.missing, ...(this.failure ? [this.failure] : [])].map((note) => element('p', {class: 'note'}, note));
    this.element = element('section', {class: 'pane', 'aria-label': run.about.label},
      element('h2', {}, run.about.label), ...notes,
      element('div', {class: 'views'},
        element('figure', {class: 'space'}, this.scene?.element, legend()),
        element('figure', {class: 'head'}, this.head.canvas, searchLegend(), this.state, this.counts)),
      element('div', {class: 'rig'}, this.rig.map((layer) => layer.element)), this.strips);
  }

  async loadModel() {
    if (!this.run.about.has_model || !this.scene) return;
    this.scene.addModel(await getBytes(`/model/${this.run.index}`));
    this.scene.show(Math.max(0, this.index));
    let pictures = await getBytes(`/pictures/${this.run.index}`);
    while (pictures.byteLength === 0) {  // they are being painted
      await new Promise((resolve) => setTimeout(resolve, 100));
      pictures = await getBytes(`/pictures/${this.run.index}`);
    }
    this.scene.addPictures(pictures);
  }

  /// An image that came with its frame.
  keep(index, bytes, [width, height]) {
    this.live.set(index, grayPicture(bytes, width, height));
    if (this.live.size > 400) this.live.delete(this.live.keys().next().value);
  }

  show(index) {
    const frame = this.run.frames[index];
    if (!frame) return;
    this.index = index;
    this.scene?.show(index);
    this.say(frame);
    this.showHead(index, frame);
    for (const layer of this.rig) layer.show(index);
    this.showCursor();
  }

  async showHead(index, frame) {
    let image = this.live.get(index) ?? null;
    if (!image && frame.stored_image) {
      const [stored] = [index, index + 1, index + 2, index - 1].filter((near) => this.run.frames[near]?.stored_image)
        .map((near) => this.images.at(near).catch(() => null));
      image = await stored;
      if (this.index !== index) return;  // another one is shown by now
    }
    this.head.show(frame, image);
    this.headIndex = index;
  }

  say(frame) {
    this.state.textContent = frame.state ? `Filter: ${frame.state}` : 'There is no filter.';
    this.state.className = `state health-${frame.health ?? 0}`;
    const of = (outcome) => (frame.searches ?? []).filter((search) => search[6] === outcome).length;
    this.counts.textContent = frame.state
      ? `${frame.landmarks} landmarks; ${(frame.searches ?? []).length} searched for: ${of('found')} found, ${of('missed')} missed, ${of('rejected')} rejected` : '';
  }

  /// Figures over time, which the program draws. html: from drawings.cc.
  showStrips(html) {
    this.strips.replaceChildren(...new DOMParser().parseFromString(html, 'text/html').body.children);
    this.figures = [...this.strips.children].map((holder) => new Figure(holder));
    follow(this.figures, (_, t) => this.go(t), () => this.showCursor());
    this.showCursor();
  }

  showCursor() {
    const frame = this.run.frames[this.index];
    if (frame) for (const figure of this.figures) figure.show(frame.t);
  }

  repaint() {
    this.scene?.paint();
    this.show(this.index);
  }
}
