// Loads the room's textures. The first picture of the scene does not wait for them.
import {getBlob, pause, picture} from './source.js';

const kPause_ms = 100;

/// Waits until the browser has displayed the last drawing.
export const drawnOnce = () =>
  new Promise((resolve) => {
    requestAnimationFrame(() => setTimeout(resolve));
  });

async function load(scene, number) {
  let painted = await getBlob(`/picture/0/${number}`);
  while (painted.size === 0) {
    // still being painted
    await pause(kPause_ms);
    painted = await getBlob(`/picture/0/${number}`);
  }
  scene.addPicture(number, await picture(painted));
}

export async function loadPictures(scene) {
  await Promise.all(Object.keys(scene.surfaces).map((number) => load(scene, number)));
  scene.draw();
}
