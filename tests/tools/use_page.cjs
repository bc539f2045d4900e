// Uses a page in headless Chromium and prints the findings as one JSON object:
// node use_page.cjs live|playback|keys|values|images|compare|rig|watch|picture URL PROFILE_FOLDER [SECONDS [PICTURE
//                   [WIDTH HEIGHT [light|dark]]]]
// node use_page.cjs report PAGE_OF_SEVERAL_RUNS.html PROFILE_FOLDER
// node use_page.cjs audit "URL_OR_PAGE..." PROFILE_FOLDER FOLDER_OF_NODE_MODULES
// Functions that are given to browser.call() and browser.when() run in the page.
const fs = require('fs');
const path = require('path');
const {say} = require('./browser.cjs');

const isReady = () => document.documentElement?.dataset.ready === 'true';
const hasModel = () => document.documentElement?.dataset.model === 'true';
/// The run has ended and the page has become its playback.
const hasEnded = () => {
  const {ended, ready, model} = document.documentElement?.dataset ?? {};
  return ended === 'true' && ready === 'true' && model === 'true';
};
/// The head image belongs to the displayed frame.
const headIsShown = () => gaitslamPage.panes[0].headIndex === gaitslamPage.panes[0].index;
const frameCount = () => gaitslamPage.panes[0].run.frames.length;
const index = () => gaitslamPage.panes[0].index;
const time = () => gaitslamPage.player.t;
const goTo = (t) => gaitslamPage.player.go(t);
const noteOf = () => gaitslamPage.note.textContent;

async function openView(browser, url) {
  await browser.open(url, isReady);
  await browser.when(hasModel);
}

async function look(browser) {
  return browser.call(() => {
    const {scene, player, panes} = gaitslamPage,
      [pane] = panes;
    scene.render();
    return {
      t: player.t,
      frames: pane.run.frames.length,
      robot: pane.run.frames[pane.index]?.bodies?.slice(0, 3),
      bodies: scene.bodies.filter((body) => body.visible).length,
      ellipsoids: scene.beliefs[0].ellipsoids.count,
      space: scene.renderer.domElement.toDataURL(),
      head: pane.head.canvas.toDataURL(),
      state: pane.state.textContent
    };
  });
}
const short = (seen) => ({...seen, space: undefined, head: undefined});

async function useLive(browser, url) {
  const moreThan = (count) => gaitslamPage.panes[0].run.frames.length > count + 3;
  await openView(browser, url);
  await browser.when(() => gaitslamPage.panes[0].index >= 0);
  const speed = await browser.call(() => gaitslamPage.controls.speeds.value);
  await browser.press('4', 52); // slowly: the next steps take time on a busy machine, and the walk is short
  const first = await look(browser);
  const isLater = (t) => gaitslamPage.player.t > t + 1 && gaitslamPage.scene.beliefs[0].ellipsoids.count > 5;
  await browser.when(isLater, first.t);
  const later = await look(browser);
  // Looking back does not delay the run; a newly opened page gets the past.
  await browser.call(goTo, 0);
  await browser.when(moreThan, await browser.call(frameCount));
  const back = await browser.call(time);
  await browser.send('Page.reload');
  await browser.rest(300);
  await browser.when(hasModel);
  await browser.when(() => gaitslamPage.panes[0].series?.t.length > 0);
  const past = await browser.call(() => {
    const [{run, series}] = gaitslamPage.panes;
    return {frame: run.frames[0].t, value: series.t[0], steps: run.landed.length};
  });
  await browser.press('4', 52); // again: without a viewer the run continued at full speed
  await browser.rest(2000);
  await browser.press(' ', 32);
  await browser.when(() => document.documentElement.dataset.playing === 'false');
  await browser.rest(700);
  const paused = await browser.call(frameCount);
  await browser.rest(700);
  const still = await browser.call(frameCount);
  await browser.press('.', 190);
  await browser.rest(500);
  const stepped = await browser.call(frameCount);
  await browser.press(' ', 32);
  await browser.when(moreThan, stepped);
  await browser.press('f', 70);
  browser.longest_ms = 400000; // a busy machine simulates the rest of the walk slower than real time
  await browser.when(hasEnded);
  const ended = await browser.call(() => gaitslamPage.about.mode);
  await browser.send('Page.reload');
  await browser.rest(500);
  await browser.when(hasEnded);
  await browser.press('Home', 36);
  await browser.press('ArrowRight', 39);
  return {
    back,
    past,
    speed,
    ended,
    after: await browser.call(index),
    received: await browser.call(frameCount),
    first: short(first),
    later: short(later),
    space_changed: first.space !== later.space,
    head_changed: first.head !== later.head,
    paused_frames: still - paused,
    stepped_frames: stepped - still,
    how: await browser.call(noteOf),
    said: browser.said
  };
}

/// Correlation of the 3D view through the camera with the head image of the same instant and of 5 s
/// earlier.
async function agreement(seconds) {
  const page = gaitslamPage,
    [pane] = page.panes,
    columns = 40,
    rows = 30;
  const gray = (source, x, width, height) => {
    const context = new OffscreenCanvas(columns, rows).getContext('2d');
    context.filter = 'blur(1px)';
    context.drawImage(source, x, 0, width, height, 0, 0, columns, rows);
    const {data} = context.getImageData(0, 0, columns, rows);
    return Array.from({length: columns * rows}, (_, i) => data[4 * i] + data[4 * i + 1] + data[4 * i + 2]);
  };
  const correlation = (a, b) => {
    const mean = (list) => list.reduce((sum, v) => sum + v, 0) / list.length,
      ma = mean(a),
      mb = mean(b);
    const sum = (of) => a.reduce((all, _, i) => all + of(a[i] - ma, b[i] - mb), 0);
    return sum((p, q) => p * q) / Math.sqrt(sum((p) => p * p) * sum((_, q) => q * q));
  };
  const imageAt = async (t) => {
    const image = await pane.images.at(pane.run.indexAt(t));
    return gray(image, 0, image.width, image.height);
  };
  const show = (on) => ['map0', 'estimate0'].forEach((layer) => page.setLayer(layer, on));
  const before = page.mode,
    space = page.scene.renderer.domElement,
    wide = (space.height * 4) / 3;
  page.player.go(seconds);
  page.setMode('head');
  show(false);
  page.scene.render();
  const seen = gray(space, (space.width - wide) / 2, wide, space.height);
  const own = correlation(seen, await imageAt(seconds));
  const earlier = correlation(seen, await imageAt(Math.max(0, seconds - 5)));
  show(true);
  page.setMode(before);
  return {own, earlier};
}

async function usePlayback(browser, url, seconds) {
  // The position of the camera in the 3D view, and which image the head view shows.
  const places = () => {
    const {player, panes, scene} = gaitslamPage,
      [pane] = panes;
    return {
      t: player.t,
      index: pane.index,
      head: pane.headIndex,
      truth: pane.run.frames[pane.index].truth.slice(0, 3),
      frustum: scene.frustum.position.toArray()
    };
  };
  await openView(browser, url);
  const start = await look(browser);
  await browser.call((t) => {
    const {slider} = gaitslamPage.controls;
    slider.value = t;
    slider.dispatchEvent(new Event('input'));
  }, seconds);
  await browser.when(headIsShown);
  const scrubbed = await browser.call(places),
    there = await look(browser);
  await browser.call((t) => {
    location.hash = `#t=${t}`;
  }, seconds);
  await browser.when((t) => Math.abs(gaitslamPage.player.t - t) < 0.001, +seconds);
  await browser.when(headIsShown);
  const linked = await browser.call(places);
  await browser.press('ArrowRight', 39);
  const next = await browser.call(places),
    agree = await browser.call(agreement, +seconds);
  const moments = await browser.call(() =>
    [...document.querySelectorAll('.moment')].map((mark) => mark.textContent)
  );
  await browser.press('c', 67);
  const through = await browser.call(() => ({mode: gaitslamPage.mode, note: gaitslamPage.note.textContent}));
  // More landmarks than were expected, and a view from below the floor.
  await browser.call(() => {
    gaitslamPage.setMode('orbit');
    document.querySelector('.scene').focus();
  });
  for (let i = 0; i < 40; ++i) await browser.press('ArrowDown', 40);
  const space = await browser.call(() => {
    const {scene} = gaitslamPage,
      [belief] = scene.beliefs;
    belief.showMap(
      Array.from({length: 3000}, (_, i) => [i, [0, 0, 1], [1, 0, 0, 0, 1, 0, 0, 0, 1]]),
      []
    );
    const {count, instanceMatrix} = belief.ellipsoids;
    return {ellipsoids: count, room: instanceMatrix.count, height: scene.camera.position.z};
  });
  return {
    there: short(there),
    scrubbed,
    linked,
    next,
    moments,
    agree,
    through,
    space,
    width_at_400: await browser.phoneWidth(),
    space_changed: start.space !== there.space,
    said: browser.said
  };
}

/// The center of an element, or a point at a fraction of its width.
const placeOf = (browser, selector, part = 0.5) =>
  browser.call(
    (of, at) => {
      const found = document.querySelector(of);
      found.scrollIntoView({block: 'center'});
      const {x, y, width, height} = found.getBoundingClientRect();
      return {x: x + at * width, y: y + height / 2};
    },
    selector,
    part
  );

const click = async (browser, selector, part) => browser.click(await placeOf(browser, selector, part));

/// How many frames an arrow key advances after a click on each control.
async function useKeys(browser, url) {
  const controls = {
    button: '.controls button',
    legend: '.legend button',
    slider: 'footer input',
    scene: '.scene canvas',
    layer: '[data-layer=truth]',
    strip: '[data-figure=error_x] svg',
    moment: '.moment'
  };
  await openView(browser, url);
  const moved = {};
  for (const [name, selector] of Object.entries(controls)) {
    await click(browser, selector, 0.3);
    await browser.call(() => gaitslamPage.player.pause());
    const before = await browser.call(index);
    await browser.press('ArrowRight', 39);
    moved[name] = (await browser.call(index)) - before;
  }
  await click(browser, '.controls button');
  await browser.press(' ', 32);
  return {moved, playing: await browser.call(() => gaitslamPage.player.playing), said: browser.said};
}

/// The mean gray values of the head image at several instants, and whether it is struck as lost.
async function readImages(browser, url, ...times) {
  const meanOf = () => {
    const [pane] = gaitslamPage.panes,
      {image, run} = pane,
      frame = run.frames[pane.index],
      context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const {data} = context.getImageData(0, 0, image.width, image.height);
    let sum = 0;
    for (let i = 0; i < data.length; i += 4) sum += data[i];
    return {
      t: frame.t,
      mean: (4 * sum) / data.length,
      isLost: pane.isLost(frame) === true
    };
  };
  await openView(browser, url);
  const see = async (t) => {
    await browser.call(goTo, t);
    await browser.when(headIsShown);
    return browser.call(meanOf);
  };
  const seen = [];
  for (const t of times) seen.push(await see(+t));
  await browser.call(() => gaitslamPage.setSeen(false));
  await browser.rest(500);
  return {seen, recorded: await see(+times[0]), said: browser.said};
}

/// Returns the figures' values at several instants of the walk, both at the cursor and at its time.
function valuesAt(count) {
  const {
      player,
      panes: [pane]
    } = gaitslamPage,
    {frames} = pane.run;
  const read = (name) =>
    [...document.querySelectorAll(`[data-figure=${name}] .legend b`)].map((value) => value.textContent);
  return Array.from({length: count}, (_, k) => {
    player.go(frames[Math.floor((k * frames.length) / count)].t);
    const [x] = read('error_x'),
      [distance] = read('distance'),
      [, landmarks] = read('landmarks'),
      rows = pane.run.mapAt(pane.index),
      ages = rows.map(([id]) => [
        id,
        parseFloat(/, ([-0-9.]+) s old/.exec(pane.run.landmarkText(pane.index, id))?.[1])
      ]);
    return {index: pane.index, t: player.t, x, distance, landmarks, ages, said: pane.counts.textContent};
  });
}

/// The landmark closest to the image's middle that the last frame searched for, and the pixel at which the page
/// shows its search.
function lastSearch() {
  const {
    player,
    panes: [pane]
  } = gaitslamPage;
  scrollTo(0, 0);
  player.go(player.duration);
  const {width: columns, height: rows} = pane.head;
  const off = ([, u, v]) => Math.hypot(u - columns / 2, v - rows / 2);
  const [id, u, v] = pane.run.frames[pane.index].searches.toSorted((a, b) => off(a) - off(b))[0];
  const {left, top, width} = pane.head.canvas.getBoundingClientRect(),
    scale = width / columns;
  return {id, x: left + scale * u, y: top + scale * v};
}

/// The page's description of the picked landmark, and how often its run found, missed and rejected it.
function pickedIn(id) {
  const {landmarks, scene, panes} = gaitslamPage;
  const outcomes = panes[0].run.frames
    .flatMap(({searches}) => searches ?? [])
    .filter((search) => search[0] === id)
    .map((search) => search[6]);
  const counts = ['found', 'missed', 'rejected'].map((how) => outcomes.filter((one) => one === how).length);
  return {id: landmarks.picked?.id, text: landmarks.text.textContent, marked: scene.mark.visible, counts};
}

/// The pixel at which the scene shows a landmark, seen through the camera.
function placeInScene(id) {
  const {scene} = gaitslamPage,
    [, p] = scene.beliefs[0].landmarks.find(([own]) => own === id);
  gaitslamPage.landmarks.pick(null);
  gaitslamPage.setMode('head');
  scene.render();
  const {left, top, width, height} = scene.renderer.domElement.getBoundingClientRect();
  const at = scene.mark.position
    .clone()
    .set(...p)
    .project(scene.head);
  return {x: left + ((at.x + 1) / 2) * width, y: top + ((1 - at.y) / 2) * height};
}

async function readValues(browser, url, count) {
  await browser.open(url, isReady);
  const at = await browser.call(valuesAt, +count);
  // After a drag the page shows the time below the mouse; after a zoom by the wheel, the cursor is at the
  // time in the legend.
  const figure = '[data-figure=distance] svg';
  const from = await placeOf(browser, figure, 0.4),
    to = await placeOf(browser, figure, 0.7);
  const share = () => gaitslamPage.player.t / gaitslamPage.player.duration;
  const scrubbed = await browser.drag(from, to, () => browser.call(share));
  await browser.mouse('mouseWheel', to, {deltaX: 0, deltaY: -100});
  const zoomed = await browser.call(() =>
    gaitslamPage.plots.figures.map(({x, cursor, holder, range}) => ({
      cursor: x.value(+/M([-0-9.]+)/.exec(cursor.getAttribute('d'))[1]),
      legend: parseFloat(holder.querySelector('.at').textContent.split(':')[1]),
      range
    }))
  );
  await click(browser, '[data-figure=error_x] .legend button');
  const hidden = await browser.call(
    () => getComputedStyle(document.querySelector('[data-figure=error_x] path.line.estimate')).display
  );
  // A landmark that is clicked in the image is marked in the scene, and vice versa.
  const last = await browser.call(lastSearch);
  await browser.click(last);
  const picked = await browser.call(pickedIn, last.id);
  await browser.click(await browser.call(placeInScene, last.id));
  picked.from_scene = await browser.call(() => {
    const {landmarks, panes} = gaitslamPage;
    return {id: landmarks.picked?.id, marked: panes[0].picked};
  });
  return {at, zoomed, scrubbed, hidden, picked, wanted: last.id, said: browser.said};
}

/// Returns the contents of a page that compares runs.
function comparison() {
  const {player, panes, scene, moments} = gaitslamPage,
    all = (selector) => [...document.querySelectorAll(selector)];
  const bottom = (selector) => document.querySelector(selector).getBoundingClientRect().bottom;
  const footer = document.querySelector('footer').getBoundingClientRect().top;
  return {
    t: player.t,
    heads: all('.pane h2').map((head) => head.textContent),
    shown: panes.map(({run, index: i}) => run.frames[i].t),
    scenes: all('.scene').length,
    ghosts: scene.beliefs.map(({frustum}) => frustum.position.toArray()),
    estimates: panes.map(({run, index: i}) => run.frames[i].estimate),
    lines: Object.fromEntries(
      all('[data-figure]').map((f) => [f.dataset.figure, f.querySelectorAll('.line').length])
    ),
    title: document.querySelector('header b').textContent,
    bottom: bottom('[data-figure=distance]') <= innerHeight,
    table: bottom('.changes tr:nth-child(5)') <= footer,
    visible: scene.beliefs.map(({path: line}) => line.object.visible),
    columns: scene.columns,
    marks: moments.partings,
    why: gaitslamPage.why.textContent,
    bands: all('[data-figure=error_x] .fill').map((band) => getComputedStyle(band).display !== 'none'),
    hash: location.hash
  };
}

const tableRows = () =>
  [...document.querySelectorAll('.changes tbody tr')].map((row) =>
    [...row.cells].map((cell) => cell.textContent)
  );

/// Picks a landmark in the first run; the second run's one is at nearly the same place.
function pickInBoth() {
  const {panes, landmarks} = gaitslamPage,
    maps = panes.map(({run, index: i}) => run.mapAt(i));
  landmarks.pick({run: 0, id: maps[0][0][0]});
  const [p, q] = maps.map((map, i) => map.find(([id]) => id === panes[i].picked)?.[1]);
  const apart = Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
  return {apart, text: landmarks.text.textContent};
}

/// The fraction of pixels that differ between the two halves of the split scene.
function differenceOfHalves() {
  const {scene} = gaitslamPage,
    source = scene.renderer.domElement,
    canvas = document.createElement('canvas');
  scene.render();
  Object.assign(canvas, {width: source.width, height: source.height});
  const context = canvas.getContext('2d', {willReadFrequently: true});
  context.drawImage(source, 0, 0);
  const half = Math.floor(canvas.width / 2);
  const [a, b] = [0, half].map((x) => context.getImageData(x, 0, half, canvas.height).data);
  let count = 0;
  for (let i = 0; i < a.length; i += 4)
    if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 60) ++count;
  return (4 * count) / a.length;
}

async function compare(browser, url) {
  await openView(browser, url);
  const table = await browser.call(tableRows);
  await click(browser, '.changes th:last-child .sort');
  const sorted = await browser.call(tableRows);
  await click(browser, '.changes tbody button');
  const worst = await browser.call(time);
  await browser.call(goTo, 0);
  await browser.press(']', 221);
  const marked = await browser.call(comparison);
  await browser.call(goTo, 0.5);
  await browser.when(headIsShown);
  const places = await browser.call(pickInBoth);
  const beyond = await browser.call(() => {
    const [pane] = gaitslamPage.panes,
      {run, series} = pane;
    pane.show(run.frames.length - 1, 1e3);
    return {value: series.x[series.at(1e3)] ?? null, state: pane.state.textContent};
  });
  await click(browser, '[data-strip=nis_vision]');
  const nis = await browser.call(() => document.querySelectorAll('[data-figure=nis_vision] .line').length);
  await browser.press('v', 86);
  const differs = await browser.call(differenceOfHalves);
  await click(browser, '[data-layer=estimate1]');
  await browser.call(() => gaitslamPage.setMode('orbit'));
  await browser.rest(500);
  const hidden = await browser.call(comparison);
  await browser.send('Page.reload');
  await browser.rest(500);
  await browser.when(hasModel);
  const again = await browser.call(comparison),
    width_at_400 = await browser.phoneWidth();
  const covered_at_400 = await browser.call(() => {
    const covers = (e) => ['fixed', 'sticky'].includes(getComputedStyle(e).position);
    const heights = [...document.querySelectorAll('footer, .controls')].map((e) =>
      covers(e) ? e.offsetHeight : 0
    );
    return Math.max(...heights);
  });
  const found = {table, sorted, worst, marked, places, beyond, nis, differs, hidden, again};
  return {...found, width_at_400, covered_at_400, said: browser.said};
}

/// The depth below the mouse, and the colors of a lidar's points by height and by intensity.
async function useRig(browser, url) {
  await openView(browser, url);
  await browser.call(() => gaitslamPage.player.go(gaitslamPage.player.duration));
  await browser.when(() => gaitslamPage.rig.every(({drawn}) => drawn));
  await browser.mouse('mouseMoved', await placeOf(browser, '.depth > canvas', 0.3));
  const depth = await browser.call(() => {
    const {at, value, canvas} = gaitslamPage.rig.find(({isDepth}) => isDepth);
    const painted = [...canvas.getContext('2d').getImageData(...at, 1, 1).data];
    return {at, text: value.textContent, bars: document.querySelectorAll('.bar').length, painted};
  });
  const sweep = () => {
    const [{geometry, material}] = gaitslamPage.scene.sweeps.values(),
      {array} = geometry.attributes.color;
    const colors = Array.from({length: array.length / 3}, (_, i) => array.slice(3 * i, 3 * i + 3).join());
    return {depthTest: material.depthTest, colors: new Set(colors).size};
  };
  const byHeight = await browser.call(sweep);
  await browser.call(() => {
    const choice = document.querySelector('.lidar select');
    choice.value = 'intensity';
    choice.dispatchEvent(new Event('change'));
  });
  return {depth, byHeight, byIntensity: await browser.call(sweep), said: browser.said};
}

/// Watches until the run has ended.
async function watch(browser, url) {
  await openView(browser, url);
  await browser.when(hasEnded);
  return {...short(await look(browser)), how: await browser.call(noteOf), said: browser.said};
}

async function picture(browser, url, seconds, file, width = 1200, height = 900, theme = 'light') {
  await browser.open(url, isReady, {width: +width, height: +height, theme});
  await browser.when(hasModel);
  await browser.when((t) => gaitslamPage.player.duration > t, +seconds);
  if (await browser.call(() => !gaitslamPage.player.live)) {
    await browser.call(goTo, +seconds);
    await browser.when(headIsShown);
  }
  await browser.rest(400);
  await browser.picture(file);
  return {said: browser.said};
}

const isDrawn = () => {
  const {figures, drawn} = document.documentElement?.dataset ?? {};
  return document.readyState === 'complete' && +figures > 0 && figures === drawn;
};

/// The names of the controls that the keyboard must reach, in page order.
function reachable() {
  const nameOf = (e) =>
    `${e.tagName.toLowerCase()} ${(e.getAttribute('aria-label') ?? e.textContent).trim()}`;
  return [...document.querySelectorAll('a[href], button, select, input, summary, [tabindex="0"]')]
    .filter((e) => e.offsetParent && !e.closest('details:not([open]) > :not(summary)'))
    .map(nameOf);
}

function focused() {
  const e = document.activeElement,
    name = (e.getAttribute('aria-label') ?? e.textContent).trim();
  return {name: `${e.tagName.toLowerCase()} ${name}`, outline: getComputedStyle(e).outlineStyle};
}

/// The controls that the Tab key reaches, and the ones without a visible focus.
async function walkThrough(browser) {
  const expected = await browser.call(reachable),
    reached = [],
    unseen = [];
  for (let i = 0; i < expected.length; ++i) {
    await browser.press('Tab', 9);
    const {name, outline} = await browser.call(focused);
    reached.push(name);
    if (outline === 'none') unseen.push(name);
  }
  return {expected, reached, unseen};
}

/// The dots of the runs over two metrics, before and after another one is chosen.
async function scatter(browser) {
  const see = () => ({
    title: document.querySelector('.scatter figcaption').textContent,
    dots: [...document.querySelectorAll('.scatter .dots')].map((dots) => dots.getAttribute('d'))
  });
  const before = await browser.call(see);
  await browser.call(() => {
    const choice = document.querySelector('.scatter select');
    choice.selectedIndex = 2;
    choice.dispatchEvent(new Event('change'));
  });
  return {before, after: await browser.call(see)};
}

/// The legend of the first figure over time with and without a cursor, and the start of the axes after a zoom
/// by dragging and a reset by double click.
async function point(browser) {
  const see = () => {
    const start = (name) => document.querySelector(`[data-figure=${name}] svg.data`).viewBox.baseVal.x;
    const legend = document.querySelector('[data-figure=error_x] .legend').textContent;
    return {legend, first: start('error_x'), other: start('error_yaw')};
  };
  const at = (part) => placeOf(browser, '[data-figure=error_x] svg', part);
  const before = await browser.call(see);
  await browser.mouse('mouseMoved', await at(0.6));
  const under = await browser.call(see);
  await browser.drag(await at(0.3), await at(0.5));
  const zoomed = await browser.call(see);
  for (const count of [1, 2]) await browser.click(await at(0.6), count);
  return {before, under, zoomed, whole: await browser.call(see)};
}

/// Returns the defects of the printed page.
function printed() {
  const all = (selector) =>
    [...document.querySelectorAll(selector)].filter((e) => e.getClientRects().length > 0);
  const nameOf = (e) =>
    `${e.closest('[data-figure]')?.dataset.figure ?? e.closest('section')?.id} ${e.tagName}`;
  const box = (e) => e.getBoundingClientRect();
  const isDark = (e) => {
    const [red, green, blue, alpha] = getComputedStyle(e)
      .backgroundColor.match(/[\d.]+/g)
      .map(Number);
    return alpha !== 0 && red + green + blue < 600;
  };
  const isCut = (e) => box(e).right > innerWidth + 1 || box(e).left < -1;
  return {
    background: getComputedStyle(document.body).backgroundColor,
    dark: all('body, figure, .card, pre, td, th').filter(isDark).map(nameOf),
    controls: all('nav, .controls, input, select, button:not(.sort, .legend button)').map(nameOf),
    cut: all('figure, figure canvas, figure svg, table, pre').filter(isCut).map(nameOf),
    too_high: all('figure')
      .filter((e) => box(e).height > innerHeight)
      .map(nameOf),
    closed: document.querySelectorAll('details:not([open])').length
  };
}

/// On A4 paper with margins of one centimeter: 718 px wide.
async function print(browser) {
  const dark = [{name: 'prefers-color-scheme', value: 'dark'}];
  await browser.call(() => dispatchEvent(new Event('beforeprint')));
  await browser.send('Emulation.setEmulatedMedia', {media: 'print', features: dark});
  await browser.resize(718, 1047);
  await browser.rest(500);
  return browser.call(printed);
}

/// The page of a report of several runs with keyboard, mouse and printer, on a dark screen.
async function useReport(browser, page) {
  await browser.open('file://' + path.resolve(page), isDrawn, {theme: 'dark'});
  await browser.send('Emulation.clearDeviceMetricsOverride');
  return {
    keyboard: await walkThrough(browser),
    scatter: await scatter(browser),
    pointed: await point(browser),
    phone: await browser.phoneWidth(),
    print: await print(browser)
  };
}

/// Serious findings of axe-core.
async function violationsIn(theme) {
  const {violations} = await globalThis.axe.run({resultTypes: ['violations']});
  return violations
    .filter(({impact}) => ['serious', 'critical'].includes(impact))
    .map(({id, nodes}) => `${theme}: ${id}: ${nodes[0].html.slice(0, 200)}`);
}

/// By page: serious findings in the light and dark themes, and the width on the narrowest phone. folder:
/// contains node_modules.
async function audit(browser, pages, folder) {
  const axe = fs.readFileSync(path.join(folder, 'node_modules/axe-core/axe.min.js'), 'utf8'),
    found = {};
  for (const page of pages.split(' ')) {
    if (page.startsWith('http')) await browser.open(page, isReady);
    else await browser.open('file://' + path.resolve(page), () => document.readyState === 'complete');
    await browser.value(`${axe};0`);
    found[page] = {findings: []};
    for (const theme of ['light', 'dark']) {
      const features = [{name: 'prefers-color-scheme', value: theme}];
      await browser.send('Emulation.setEmulatedMedia', {features});
      found[page].findings.push(...(await browser.call(violationsIn, theme)));
    }
    found[page].width = await browser.phoneWidth(360);
  }
  return found;
}

const [what, target, profile, ...more] = process.argv.slice(2);
const uses = {
  live: useLive,
  playback: usePlayback,
  keys: useKeys,
  values: readValues,
  compare,
  rig: useRig,
  images: readImages,
  watch,
  picture,
  report: useReport,
  audit
};
say(profile, (browser) => uses[what](browser, target, ...more));
