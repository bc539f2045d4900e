// Loads a finished result, or several.
import {Series} from './compare.js';
import {readAddress} from './address.js';
import {drawnOnce, loadPictures} from './model.js';
import {getBytes, getJson} from './source.js';

/// Requests the data for the first picture.
export const firstFiles = (runs) =>
  runs.map((_, i) => ({series: getBytes(`/series/${i}`), frames: getJson(`/frames/${i}/0`)}));

/// Adds a piece of a few seconds from each run that has it.
async function appendPiece(panes, piece, first) {
  const append = async ({run}, i) => {
    if (piece >= run.about.pieces) return;
    for (const frame of await (piece === 0 ? first[i].frames : getJson(`/frames/${i}/${piece}`)))
      run.append(frame);
  };
  await Promise.all(panes.map(append));
}

/// The first picture is drawn only once, when it is complete, because every drawing of the scene or of a
/// figure delays the next one.
async function showFirst(page, first, model, images) {
  await Promise.all(images);
  page.addModel(await model);
  await drawnOnce();
  const pictures = loadPictures(page.scene);
  const load = async (pane, i) => {
    pane.series = Series.of(await first[i].series);
  };
  await Promise.all(page.panes.map(load));
  page.drawFigures();
  return pictures;
}

/// Frames arrive in pieces, in order; the time in the URL is shown as soon as its frames are available.
export async function playBack(page, first, model) {
  const {panes, player} = page,
    wanted = readAddress().t;
  const shown = panes.filter((pane) => !pane.first && pane.run.about.camera);
  const images = shown.map((pane) => pane.images.at(0).catch(() => null));
  let isThere = false,
    pictures = null;
  for (let piece = 0; panes.some(({run}) => piece < run.about.pieces); ++piece) {
    await appendPiece(panes, piece, first);
    if (piece === 0) pictures = await showFirst(page, first, model, images);
    if (!isThere && player.t === 0 && wanted <= player.duration) isThere = page.goToAddress();
  }
  for (const {run, series} of panes) series.addFeet(run.frames);
  if (panes.length > 1) page.addPartings();
  else page.drawFigures();
  if (!isThere && player.t === 0) page.goToAddress();
  player.show(player.t);
  page.dataset.ready = 'true';
  await pictures;
}
