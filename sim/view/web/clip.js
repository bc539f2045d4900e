// Saves pictures and videos of the page.
import {element} from '../../pages/web/dom.js';

const kLong_ms = 10000,
  kFrames_hz = 30;

export function save(blob, download) {
  const href = URL.createObjectURL(blob);
  element('a', {href, download}).click();
  URL.revokeObjectURL(href);
}

/// Plays 10 s in real time and saves the scene and the first head image, side by side, as WebM.
export async function saveClip(page, from) {
  const {scene, player, panes} = page,
    space = scene.renderer.domElement,
    head = panes[0].head.canvas,
    width = Math.round((head.width * space.height) / head.height);
  const canvas = element('canvas', {width: space.width + width, height: space.height}),
    context = canvas.getContext('2d'),
    recorder = new MediaRecorder(canvas.captureStream(kFrames_hz), {mimeType: 'video/webm'}),
    pieces = [];
  recorder.ondataavailable = ({data}) => pieces.push(data);
  const stopped = new Promise((resolve) => {
    recorder.onstop = resolve;
  });
  page.setSpeed(1);
  player.go(from);
  player.resume();
  recorder.start();
  const end = performance.now() + kLong_ms;
  const draw = () => {
    scene.render();
    context.drawImage(space, 0, 0);
    context.drawImage(head, space.width, 0, width, space.height);
    if (performance.now() < end) requestAnimationFrame(draw);
    else recorder.stop();
  };
  draw();
  await stopped;
  player.pause();
  save(new Blob(pieces, {type: 'video/webm'}), `gaitslam-${from.toFixed(1)}s.webm`);
}
