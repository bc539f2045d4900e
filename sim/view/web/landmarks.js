// The landmark picked by the reader, and the landmarks that runs have in common.
import {element} from '../../pages/web/dom.js';
import {matched} from './compare.js';

const kStill_px = 5;
const mapOf = ({run, index}) => run.mapAt(index);

export class Landmarks {
  /// changed(): another landmark is picked.
  constructor(panes, scene, changed) {
    this.panes = panes;
    this.changed = changed;
    this.scene = scene;
    this.picked = null; // {run, id}
    const advice = 'Click a landmark in the scene or in an image to identify it.';
    this.text = element('p', {class: 'soft', role: 'status'}, advice);
    this.followClicks();
  }

  followClicks() {
    const {element: space} = this.scene;
    let from = null;
    // After a click in the scene, no other element may keep the keyboard focus either.
    space.addEventListener('pointerup', () => document.activeElement.blur());
    space.addEventListener(
      'pointerdown',
      (event) => {
        from = event;
      },
      true
    );
    space.addEventListener('click', (event) => {
      const moved = from ? Math.hypot(event.clientX - from.clientX, event.clientY - from.clientY) : Infinity;
      if (moved < kStill_px) this.pick(this.scene.pick(event)); // otherwise the view was rotated
    });
    for (const pane of this.panes) {
      pane.head.canvas.addEventListener('click', (event) => this.pick(pane.pick(event)));
    }
  }

  /// Describes a landmark and highlights it in the scene and the images; null: none.
  pick(landmark) {
    this.picked = landmark;
    this.mark();
    this.changed();
  }

  /// Shows the displayed frame.
  show() {
    if (this.picked) this.mark();
  }

  mark() {
    this.scene.showPicked(this.picked);
    const texts = this.panes.map((pane, k) => {
      const id = this.idIn(k);
      pane.mark(id ?? null);
      return id === undefined
        ? ''
        : `${pane.name ? `${pane.name}: ` : ''}${pane.run.landmarkText(pane.index, id)}`;
    });
    if (this.picked) this.text.textContent = texts.filter(Boolean).join(' · at the same place: ');
  }

  /// The picked landmark's number in the k-th run, or undefined.
  idIn(k) {
    if (!this.picked) return undefined;
    const {run, id} = this.picked;
    return k === run ? id : matched(mapOf(this.panes[run]), mapOf(this.panes[k])).get(id);
  }
}
