// The figures over time below the scene, and the one above the controls.
import {button, element} from '../../pages/web/dom.js';
import {follow} from '../../pages/web/figures.js';
import {figures, kOnDemand, known, timeLine} from './compare.js';

const kMargin_px = 28,
  kLeast_px = 320;

export class Plots {
  /// go(t, goesOn): goes to a time; changed(): which figures are shown, or their zoom, changed; player: its
  /// time is shown.
  constructor(panes, player, {go, changed}) {
    this.panes = panes;
    this.player = player;
    this.callbacks = {go, changed};
    this.seen = new Set(); // figures on the screen
    this.observer = new IntersectionObserver((entries) => {
      for (const {target, isIntersecting} of entries) this.seen[isIntersecting ? 'add' : 'delete'](target);
    });
    this.hidden = new Set(kOnDemand);
    this.figures = [];
    this.timeLine = element('div', {class: 'timeline'});
    this.strips = element('div', {class: 'strips'});
    this.names = element('p', {class: 'key'});
    const resized = () => this.figures.length && this.width !== innerWidth && this.draw();
    new ResizeObserver(resized).observe(document.body);
  }

  /// Draws the figures; keepsZoom: over the range now shown. A figure under the mouse is redrawn only on
  /// request.
  draw({marks = this.marks, keepsZoom = true, isAsked = false} = {}) {
    this.marks = marks;
    const runs = this.panes.filter(({series}) => series);
    const isUsed = this.timeLine.matches(':hover') || this.strips.matches(':hover');
    if (!runs.length || (isUsed && !isAsked)) return;
    const zoomed = this.figures[0]?.range;
    this.width = innerWidth;
    const line = timeLine(runs, marks, Math.max(kLeast_px, innerWidth - kMargin_px));
    const strips = figures(runs, marks, this.hidden);
    this.figures = [line, ...strips].filter(Boolean);
    this.names.replaceChildren('Figures: ', ...known(runs).map((name) => this.switchOf(name)));
    this.timeLine.replaceChildren(...(line ? [line.holder] : []));
    this.strips.replaceChildren(...strips.map(({holder}) => holder));
    follow(this.overTime, this.callbacks.go, () => this.show(), this.callbacks.changed, true);
    this.observer.disconnect();
    this.seen.clear();
    for (const {holder} of this.figures) this.observer.observe(holder);
    if (zoomed && keepsZoom) this.zoom(...zoomed);
    this.show();
  }

  get overTime() {
    return this.figures.filter(({overTime}) => overTime);
  }

  switchOf(name) {
    const pressed = String(!this.hidden.has(name));
    return button(name.replaceAll('_', ' '), 'show or hide', () => this.toggle(name), {
      'data-strip': name,
      'aria-pressed': pressed,
      class: 'layer'
    });
  }

  toggle(name) {
    if (!this.hidden.delete(name)) this.hidden.add(name);
    this.draw({isAsked: true});
    this.callbacks.changed();
  }

  zoom(low, high) {
    for (const figure of this.overTime) figure.zoom(low, high);
  }

  /// Puts the cursor at the displayed time; while the player plays, only in figures on the screen.
  show() {
    const {t, playing} = this.player;
    for (const figure of this.overTime) if (!playing || this.seen.has(figure.holder)) figure.show(t);
  }
}
