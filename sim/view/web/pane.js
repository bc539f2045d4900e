// One run next to the scene: its head image with searches, and its state in words.
import {element} from '../../pages/web/dom.js';
import {kOutcomes} from './run.js';
import {HeadView, grayPicture} from './sensors.js';
import {Stored, picture} from './source.js';

const kEnded_s = 0.1;
const kSigns = {found: '◯▫', missed: '◌', rejected: '◯×'};
export const searchLegend = (isShared) =>
  element(
    'p',
    {class: 'key'},
    `searches, 3σ${isShared ? ', in the color of the run' : ''}: `,
    ...Object.keys(kOutcomes).map((outcome) =>
      element('b', {class: isShared ? '' : outcome}, `${kSigns[outcome]} ${outcome}`)
    ),
    element('b', {class: 'new'}, '▫ new')
  );

function countsOf({searches = []}) {
  const outcomes = Object.keys(kOutcomes).map(
    (outcome) => `${searches.filter((search) => search[6] === outcome).length} ${outcome}`
  );
  return `${searches.length} searched for: ${outcomes.join(', ')}`;
}

export class Pane {
  /// name: a letter if there are several runs; difference: what distinguishes this run from the others; role:
  /// its color; first: the pane with this run's image, which shows the searches of all its runs.
  constructor(run, name, difference, role, first = null) {
    Object.assign(this, {
      run,
      name,
      full: [name, difference].filter(Boolean).join(': '),
      role,
      index: -1,
      picked: null,
      first,
      shared: [this]
    });
    first?.shared.push(this);
    this.images = new Stored(`/rig/${run.index}/${run.about.rig.length}`, picture, 400);
    const {width, height} = run.camera;
    const gray = async (blob) => grayPicture(new Uint8Array(await blob.arrayBuffer()), width, height);
    this.seen = new Stored(`/seen/${run.index}`, gray, 400);
    this.isSeen = run.about.seen !== null;
    this.live = new Map();
    this.head = new HeadView(run, name);
    this.state = element('p', {class: 'state', role: 'status'});
    this.counts = element('p', {class: 'soft'});
    const notes = run.about.missing.map((note) => element('p', {class: 'note'}, note));
    this.element = element(
      'section',
      {class: 'pane', 'aria-label': this.full || run.about.label},
      name ? element('h2', {class: `role-${role}`, title: this.full}, this.full) : null,
      ...notes,
      first ? null : this.head.canvas,
      this.state,
      this.counts
    );
  }

  keep(index, bytes, [width, height]) {
    this.live.set(index, grayPicture(bytes, width, height));
    if (this.live.size > 400) this.live.delete(this.live.keys().next().value);
  }

  show(index, t) {
    const frame = this.run.frames[index];
    if (!frame) return;
    this.index = index;
    this.say(frame, frame === this.run.frames.at(-1) && t > frame.t + kEnded_s);
    if (!this.first) this.showHead(index, frame);
  }

  /// Highlights a landmark in the image; null: none.
  mark(id) {
    this.picked = id;
    const pane = this.first ?? this;
    if (pane.headIndex === pane.index) pane.drawHead();
  }

  /// The landmark searched for in the image nearest to a position on the page; null: none.
  pick(event) {
    const near = this.shared.map(({run, index}) => ({
      run: run.index,
      ...this.head.pick(event, run.frames[index] ?? {})
    }));
    const [found] = near.sort((a, b) => a.far - b.far);
    return found.id === undefined ? null : found;
  }

  drawHead() {
    const frames = this.shared
      .filter(({run, index}) => run.frames[index])
      .map(({run, index, role, picked}) => ({frame: run.frames[index], role, picked}));
    this.head.show(this.image, frames, this.isLost(this.run.frames[this.headIndex]));
  }

  /// The filter got no image with a frame.
  isLost({state, image, stored_image: isStored, source}) {
    return this.run.about.duration ? this.isSeen && isStored && source === undefined : state && !image;
  }

  /// The image of a frame: as the filter got it, or as recorded if it was lost or on request.
  imageOf({source}, index) {
    const isGot = this.isSeen && source !== undefined;
    return (isGot ? this.seen.at(source) : this.images.at(index)).catch(() => null);
  }

  async showHead(index, frame) {
    let image = this.live.get(index) ?? null;
    if (!image && frame.stored_image) {
      const {isSeen} = this;
      const [shown] = [index, index + 1, index + 2, index - 1]
        .filter((near) => this.run.frames[near]?.stored_image)
        .map((near) => this.imageOf(this.run.frames[near], near));
      image = await shown;
      if (this.index !== index || this.isSeen !== isSeen) return; // a different image is shown by now
    }
    this.image = image;
    this.headIndex = index;
    this.drawHead();
  }

  /// isSeen: shows the images as the filter got them, otherwise as recorded.
  setSeen(isSeen) {
    this.isSeen = isSeen && this.run.about.seen !== null;
    if (this.run.frames[this.index] && !this.first) this.showHead(this.index, this.run.frames[this.index]);
  }

  /// hasEnded: this run has ended, but a longer one has not.
  say(frame, hasEnded) {
    this.state.textContent = hasEnded
      ? `The run ended at ${frame.t.toFixed(2)} s.`
      : frame.state
        ? `Filter: ${frame.state}`
        : 'There is no filter.';
    this.state.className = `state health-${frame.health ?? 0}`;
    this.counts.textContent = frame.state ? `${this.run.mapText(this.index)}; ${countsOf(frame)}` : '';
  }
}
