// Follows a live run.
import {writeAddress} from './address.js';
import {Series} from './compare.js';
import {drawnOnce, loadPictures} from './model.js';
import {listen} from './source.js';

/// Handlers of the program's messages.
const kMessages = {
  past: (page, {frames}) => frames.forEach((frame) => page.panes[0].run.append(frame)),
  series(page, {names, from, rows}) {
    const [pane] = page.panes;
    pane.series ??= new Series(names);
    pane.series.add(from, rows);
    page.drawFigures();
  },
  pace(page, {paused, speed}) {
    page.controls.speeds.value = speed;
    if (!page.player.control) return;
    page.player.playing = !paused;
    page.sayPlay();
  },
  /// The program now serves the result at the same address.
  finished(page) {
    writeAddress(page.addressValues());
    location.reload();
  },
  ended(page, {how, frames}) {
    const {length} = page.panes[0].run.frames,
      {speeds, step} = page.controls;
    page.player.end();
    page.setEnded(length < frames ? `${how} This page received ${length} of ${frames} frames.` : how);
    speeds.disabled = step.disabled = false;
    speeds.value = 1;
    page.drawFigures();
    page.sayPlay();
  },
  rejected: (page, {why}) => {
    page.note.textContent = why;
  }
};

/// Returns a function that adds a frame, and that draws the newest one before the browser next repaints the
/// page.
function receiver(page) {
  const {
    player,
    panes: [pane]
  } = page;
  let drawing = false;
  const draw = () => {
    drawing = false;
    if (player.atEnd) player.show(player.duration);
  };
  return (frame, image) => {
    if (!pane.run.append(frame)) return;
    if (frame.image) pane.keep(pane.run.frames.length - 1, image, frame.image);
    page.dataset.ready = 'true';
    if (!player.atEnd || drawing) return;
    drawing = true;
    requestAnimationFrame(draw);
  };
}

export async function followLive(page, model) {
  const {player, note} = page;
  player.send = listen({
    frame: receiver(page),
    message: (message) => kMessages[message.op]?.(page, message),
    closed: () => {
      if (player.live)
        note.textContent = 'The connection was closed because the run or its program has ended.';
    }
  });
  try {
    page.addModel(await model);
    await drawnOnce();
    await loadPictures(page.scene);
  } finally {
    player.send({op: 'loaded'});
  }
}
