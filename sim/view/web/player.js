// The displayed time and how it advances: playback, or the newest frame of a live run.

const kFast = 5; // at full speed, the browser draws every fifth frame of a finished run

export class Player {
  /// panes: the runs; the first one has the frames that are stepped through. live: the run is in progress.
  /// control: it can be paused. show(t): displays a time; said(): play or pause changed; moved(): the reader
  /// went to a time.
  constructor(panes, {live, control}, {show, said, moved}) {
    this.panes = panes;
    this.live = live;
    this.control = control;
    this.callbacks = {show, said, moved};
    this.t = 0;
    this.playing = live;
    this.atEnd = true; // a live view shows the newest frame
    this.speed = 1;
    this.send = () => {};
  }

  get run() {
    return this.panes[0].run;
  }

  get duration() {
    return Math.max(...this.panes.map(({run}) => run.duration));
  }

  get index() {
    return Math.max(0, this.run.indexAt(this.t));
  }

  /// The frame that many `frames` later, clamped to the first or last one.
  frameAfter(frames) {
    return this.run.frames[Math.min(Math.max(this.index + frames, 0), this.run.frames.length - 1)];
  }

  show(t) {
    this.t = t;
    this.callbacks.show(t);
  }

  /// Goes to a time, which in a live view affects only this viewer. goesOn: more such times follow at once.
  go(t, goesOn = false) {
    if (!Number.isFinite(t)) return;
    this.atEnd = false;
    if (this.playing && !this.live) this.pause();
    if (this.live) this.callbacks.said();
    this.show(Math.min(Math.max(t, 0), this.duration));
    if (!goesOn) this.callbacks.moved();
  }

  toggle() {
    if (this.playing && (this.atEnd || !this.live)) this.pause();
    else this.resume();
  }

  pause() {
    this.playing = false;
    if (this.live && this.control) this.send({op: 'pause'});
    else this.atEnd = !this.live;
    this.callbacks.said();
  }

  resume() {
    const wasPlaying = this.playing;
    this.playing = this.atEnd = true;
    if (this.live) {
      if (this.control && !wasPlaying) this.send({op: 'resume'});
      this.show(this.duration);
    } else {
      if (this.t >= this.duration) this.show(0);
      this.since = undefined;
      requestAnimationFrame((now) => this.tick(now));
    }
    this.callbacks.said();
  }

  tick(now) {
    if (!this.playing) return;
    const passed = (now - (this.since ?? now)) / 1000;
    this.since = now;
    const next = this.speed > 0 ? this.t + this.speed * passed : this.frameAfter(kFast).t;
    this.show(Math.min(next, this.duration));
    if (this.t >= this.duration) this.pause();
    else requestAnimationFrame((later) => this.tick(later));
  }

  /// frames > 0: forward; < 0: back.
  stepBy(frames) {
    this.go(this.frameAfter(frames)?.t);
  }

  /// Shows the next frame; pauses a live run after it.
  step() {
    if (!this.live) return this.stepBy(1);
    if (!this.control) return undefined;
    this.playing = false;
    this.atEnd = true;
    this.send({op: 'step'});
    return this.callbacks.said();
  }

  setSpeed(speed) {
    this.speed = speed;
    if (this.live) this.send({op: 'speed', factor: speed});
  }

  /// Makes the received part of a live run playable after its end.
  end() {
    this.live = this.playing = false;
    this.speed = 1;
  }
}
