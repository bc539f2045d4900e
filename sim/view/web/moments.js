// The marks of events on the timeline.
import {button, element} from '../../pages/web/dom.js';

const kNear_s = 0.005;

/// The events of the runs. Events of several runs at the same time are merged, without names if all runs
/// have them.
function eventsOf(panes) {
  const events = new Map();
  for (const {name, run} of panes) {
    for (const moment of run.about.moments) {
      const key = `${moment.t.toFixed(2)} ${moment.text}`;
      const names = [...(events.get(key)?.names ?? []), name].filter(Boolean);
      const isOfAll = [0, panes.length].includes(names.length);
      events.set(key, {
        ...moment,
        names,
        text: isOfAll ? moment.text : `${names.join(', ')}: ${moment.text}`
      });
    }
  }
  return [...events.values()];
}

export class Moments {
  /// go(t): goes to a mark.
  constructor(panes, go) {
    this.panes = panes;
    this.go = go;
    this.partings = [];
    this.element = element('nav', {'aria-label': 'moments'});
    this.list();
  }

  /// Updates the list of events and of times at which runs differ.
  list() {
    this.marks = [...this.partings, ...eventsOf(this.panes)].sort((a, b) => a.t - b.t);
    this.element.replaceChildren(...this.marks.map((mark) => this.buttonOf(mark)));
  }

  buttonOf({t, text, kind}) {
    const words = `${t.toFixed(2)} s ${text}`;
    return button(words, `${words} ([ and ]: previous and next)`, () => this.go(t), {
      class: `moment ${kind}`
    });
  }

  /// step > 0: goes to the mark after a time; otherwise to the previous one.
  jump(t, step) {
    const times = this.marks.map((mark) => mark.t);
    const next = step > 0 ? times.find((at) => at > t + kNear_s) : times.findLast((at) => at < t - kNear_s);
    if (next !== undefined) this.go(next);
  }
}
