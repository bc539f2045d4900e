// Uses a page in headless Chromium and prints the findings as one JSON object. Usage: node use_page.cjs
// live|playback|keys|values|compare|rig|watch|picture URL PROFILE_FOLDER [SECONDS [PICTURE [WIDTH HEIGHT
// [light|dark]]]] node use_page.cjs report PAGE_OF_SEVERAL_RUNS.html PROFILE_FOLDER node use_page.cjs audit
// "URL_OR_PAGE..." PROFILE_FOLDER FOLDER_OF_NODE_MODULES
const fs = require('fs');
const path = require('path');
const {say} = require('./browser.cjs');

const kReady = `document.documentElement?.dataset.ready === 'true'`;
const kPane = 'gaitslamPage.panes[0]',
  kFrame = `${kPane}.run.frames[${kPane}.index]`;
const openView = async (browser, url, more = '') => {
  await browser.open(url, kReady);
  await browser.until(`document.documentElement?.dataset.model === 'true'${more}`);
};
const look = (browser) =>
  browser.value(`(gaitslamPage.scene.render(), {t: gaitslamPage.player.t, frames: ${kPane}.run.frames.length, robot: ${kFrame}.bodies?.slice(0, 3),
  bodies: gaitslamPage.scene.bodies.filter((b) => b.visible).length, ellipsoids: gaitslamPage.scene.beliefs[0].ellipsoids.count,
  space: gaitslamPage.scene.renderer.domElement.toDataURL(), head: ${kPane}.head.canvas.toDataURL(), state: ${kPane}.state.textContent})`);
const short = (seen) => ({...seen, space: undefined, head: undefined});

async function useLive(browser, url) {
  await openView(browser, url, ` && !!${kFrame}`);
  await browser.press('4', 52); // slowly: what follows takes a busy machine some time, and the walk is short
  const first = await look(browser);
  await browser.until(
    `gaitslamPage.player.t > ${first.t} + 1 && gaitslamPage.scene.beliefs[0].ellipsoids.count > 5`
  );
  const later = await look(browser);
  // Looking back does not hold up the run; a page that is opened anew gets the past.
  await browser.value('gaitslamPage.player.go(0)');
  const held = await browser.value(`${kPane}.run.frames.length`);
  await browser.until(`${kPane}.run.frames.length > ${held} + 3`);
  const back = await browser.value('gaitslamPage.player.t');
  await browser.send('Page.reload');
  await browser.rest(300);
  await browser.until(`document.documentElement?.dataset.model === 'true' && ${kPane}.series?.t.length > 0`);
  const past = await browser.value(
    `({frame: ${kPane}.run.frames[0].t, value: ${kPane}.series.t[0], steps: ${kPane}.run.landed.length})`
  );
  await browser.press('4', 52); // again: without a viewer the run went on at full speed
  await browser.rest(2000);
  await browser.press(' ', 32);
  await browser.until(`document.documentElement?.dataset.playing === 'false'`);
  await browser.rest(700);
  const paused = await browser.value(`${kPane}.run.frames.length`);
  await browser.rest(700);
  const still = await browser.value(`${kPane}.run.frames.length`);
  await browser.press('.', 190);
  await browser.rest(500);
  const stepped = await browser.value(`${kPane}.run.frames.length`);
  await browser.press(' ', 32);
  await browser.until(`${kPane}.run.frames.length > ${stepped} + 3`);
  await browser.press('f', 70);
  await browser.until(`document.documentElement?.dataset.ended === 'true'`, 120000);
  await browser.press('Home', 36);
  await browser.press('ArrowRight', 39);
  const after = await browser.value(`${kPane}.index`);
  return {
    back,
    past,
    after,
    received: await browser.value(`${kPane}.run.frames.length`),
    first: short(first),
    later: short(later),
    space_changed: first.space !== later.space,
    head_changed: first.head !== later.head,
    paused_frames: still - paused,
    stepped_frames: stepped - still,
    how: await browser.value('gaitslamPage.note.textContent'),
    said: browser.said
  };
}

// The position of the camera in the 3D view, and which image the head view shows.
const kPlaces = `({t: gaitslamPage.player.t, index: ${kPane}.index, head: ${kPane}.headIndex, truth: ${kFrame}.truth.slice(0, 3),
  frustum: gaitslamPage.scene.frustum.position.toArray()})`;

// Correlation of the 3D view through the camera with the head image of the same instant and with that of 5 s
// before.
const agreement = async (seconds) => {
  const page = globalThis.gaitslamPage,
    [pane] = page.panes,
    columns = 40,
    rows = 30;
  const gray = (source, x, width, height) => {
    const canvas = new OffscreenCanvas(columns, rows),
      context = canvas.getContext('2d');
    context.filter = 'blur(1px)';
    context.drawImage(source, x, 0, width, height, 0, 0, columns, rows);
    const {data} = context.getImageData(0, 0, columns, rows);
    return Array.from({length: columns * rows}, (_, i) => data[4 * i] + data[4 * i + 1] + data[4 * i + 2]);
  };
  const correlation = (a, b) => {
    const mean = (list) => list.reduce((s, v) => s + v, 0) / list.length,
      ma = mean(a),
      mb = mean(b);
    const sum = (f) => a.reduce((s, _, i) => s + f(a[i] - ma, b[i] - mb), 0);
    return sum((p, q) => p * q) / Math.sqrt(sum((p) => p * p) * sum((_, q) => q * q));
  };
  const imageAt = async (t) => {
    const image = await pane.images.at(pane.run.indexAt(t));
    return gray(image, 0, image.width, image.height);
  };
  page.player.go(seconds);
  const before = page.mode;
  page.setMode('head');
  const space = page.scene.renderer.domElement,
    wide = (space.height * 4) / 3;
  page.setLayer('map0', false);
  page.setLayer('estimate0', false);
  page.scene.render();
  const seen = gray(space, (space.width - wide) / 2, wide, space.height);
  const found = {
    own: correlation(seen, await imageAt(seconds)),
    earlier: correlation(seen, await imageAt(Math.max(0, seconds - 5)))
  };
  page.setLayer('map0', true);
  page.setLayer('estimate0', true);
  page.setMode(before);
  return found;
};

async function usePlayback(browser, url, seconds) {
  await openView(browser, url);
  const start = await look(browser);
  await browser.value(
    `(gaitslamPage.controls.slider.value = ${seconds}, gaitslamPage.controls.slider.dispatchEvent(new Event('input')))`
  );
  await browser.until(`${kPane}.headIndex === ${kPane}.index`);
  const scrubbed = await browser.value(kPlaces),
    there = await look(browser);
  await browser.value(`location.hash = '#t=${seconds}'`);
  await browser.until(
    `${kPane}.headIndex === ${kPane}.index && Math.abs(gaitslamPage.player.t - ${seconds}) < 0.001`
  );
  const linked = await browser.value(kPlaces);
  await browser.press('ArrowRight', 39);
  const next = await browser.value(kPlaces);
  const agree = await browser.value(`(${agreement})(${seconds})`, true);
  const moments = await browser.value(`[...document.querySelectorAll('.moment')].map((b) => b.textContent)`);
  await browser.press('c', 67);
  const through = await browser.value(`({mode: gaitslamPage.mode, note: gaitslamPage.note.textContent})`);
  // More landmarks than were expected, a view from below the floor, and a graphics card that fails for a
  // while.
  await browser.value(`(gaitslamPage.setMode('orbit'), document.querySelector('.scene').focus())`);
  for (let i = 0; i < 40; ++i) await browser.press('ArrowDown', 40);
  const space =
    await browser.value(`(() => { const {scene} = gaitslamPage, [belief] = scene.beliefs; belief.showMap(Array.from({length: 3000}, (_, i) => [i, [0, 0, 1], [1, 0, 0, 0, 1, 0, 0, 0, 1]]), []);
    return {ellipsoids: belief.ellipsoids.count, room: belief.ellipsoids.instanceMatrix.count, height: scene.camera.position.z}; })()`);
  const said = [...browser.said],
    isLost = `document.querySelector('.scene').classList.contains('lost')`;
  await browser.value('gaitslamPage.scene.renderer.forceContextLoss()');
  await browser.until(isLost);
  await browser.value('gaitslamPage.scene.renderer.forceContextRestore()');
  await browser.until(`!${isLost}`);
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
    said
  };
}

// The center of an element, or a point at a fraction of its width.
const placeOf = (browser, selector, part = 0.5) =>
  browser.value(`(() => { const e = document.querySelector('${selector}'); e.scrollIntoView({block: 'center'});
  const {x, y, width, height} = e.getBoundingClientRect(); return {x: x + ${part} * width, y: y + height / 2}; })()`);

const click = async (browser, selector, part) => browser.click(await placeOf(browser, selector, part));

// How many frames an arrow key advances after a click on each control.
async function useKeys(browser, url) {
  await openView(browser, url);
  const moved = {};
  for (const [name, selector] of Object.entries({
    button: '.controls button',
    legend: '.legend button',
    slider: 'footer input',
    scene: '.scene canvas',
    layer: '[data-layer=truth]',
    strip: '[data-figure=error_x] svg',
    moment: '.moment'
  })) {
    await click(browser, selector, 0.3);
    await browser.value('gaitslamPage.player.pause()');
    const before = await browser.value(`${kPane}.index`);
    await browser.press('ArrowRight', 39);
    moved[name] = (await browser.value(`${kPane}.index`)) - before;
  }
  await click(browser, '.controls button');
  await browser.press(' ', 32);
  return {moved, playing: await browser.value('gaitslamPage.player.playing'), said: browser.said};
}

// What the figures show at several instants of the walk, both at the cursor and at its time.
async function readValues(browser, url, count) {
  await browser.open(url, kReady);
  const at =
    await browser.value(`(() => { const values = [], {frames} = ${kPane}.run; for (let k = 0; k < ${count}; ++k) {
    gaitslamPage.player.go(frames[Math.floor(k * frames.length / ${count})].t);
    const read = (name) => [...document.querySelectorAll('[data-figure=' + name + '] .legend b')].map((b) => b.textContent);
    values.push({index: ${kPane}.index, t: gaitslamPage.player.t, x: read('error_x')[0], distance: read('distance')[0], landmarks: read('landmarks')[1]});
  } return values; })()`);
  // After a drag the page shows the time below the mouse; after a zoom by the wheel, the cursor is at the
  // time in the legend.
  const figure = '[data-figure=distance] svg',
    [from, to] = [await placeOf(browser, figure, 0.4), await placeOf(browser, figure, 0.7)];
  const scrubbed = await browser.drag(from, to, () =>
    browser.value('gaitslamPage.player.t / gaitslamPage.player.duration')
  );
  await browser.mouse('mouseWheel', to, {deltaX: 0, deltaY: -100});
  const zoomed =
    await browser.value(`gaitslamPage.plots.figures.map((f) => ({cursor: f.x.value(+/M([-0-9.]+)/.exec(f.cursor.getAttribute('d'))[1]),
    legend: parseFloat(f.holder.querySelector('.at').textContent.split(':')[1]), range: f.range}))`);
  const line = `document.querySelector('[data-figure=error_x] path.line.estimate')`;
  await click(browser, '[data-figure=error_x] .legend button');
  const hidden = await browser.value(`getComputedStyle(${line}).display`);
  // A landmark that is clicked in the image is marked in the scene, and vice versa.
  const last =
    await browser.value(`(() => { const pane = ${kPane}; scrollTo(0, 0); gaitslamPage.player.go(gaitslamPage.player.duration);
    const [id, u, v] = pane.run.frames[pane.index].searches[0], {left, top, width} = pane.head.canvas.getBoundingClientRect(), scale = width / pane.head.width;
    return {id, x: left + scale * u, y: top + scale * v}; })()`);
  await browser.click(last);
  const picked =
    await browser.value(`({id: gaitslamPage.landmarks.picked?.id, text: gaitslamPage.landmarks.text.textContent, marked: gaitslamPage.scene.mark.visible, counts: ['found', 'missed', 'rejected'].map((how) =>
    ${kPane}.run.frames.flatMap(({searches}) => searches ?? []).filter((search) => search[0] === ${last.id} && search[6] === how).length)})`);
  await browser.value('gaitslamPage.landmarks.pick(null)');
  const again =
    await browser.value(`(() => { const {scene} = gaitslamPage, [, p] = scene.beliefs[0].landmarks.find(([id]) => id === ${last.id});
    gaitslamPage.setMode('head'); scene.render(); const {left, top, width, height} = scene.renderer.domElement.getBoundingClientRect(), at = scene.mark.position.clone().set(...p).project(scene.head);
    return {x: left + (at.x + 1) / 2 * width, y: top + (1 - at.y) / 2 * height}; })()`);
  await browser.click(again);
  picked.from_scene = await browser.value(
    '({id: gaitslamPage.landmarks.picked?.id, marked: gaitslamPage.panes[0].picked})'
  );
  return {at, zoomed, scrubbed, hidden, picked, wanted: last.id, said: browser.said};
}

async function compare(browser, url) {
  await openView(browser, url);
  const read = () =>
    browser.value(`({t: gaitslamPage.player.t, heads: [...document.querySelectorAll('.pane h2')].map((h) => h.textContent),
    shown: gaitslamPage.panes.map(({run, index}) => run.frames[index].t), scenes: document.querySelectorAll('.scene').length,
    ghosts: gaitslamPage.scene.beliefs.map(({frustum}) => frustum.position.toArray()), estimates: gaitslamPage.panes.map(({run, index}) => run.frames[index].estimate),
    lines: Object.fromEntries([...document.querySelectorAll('[data-figure]')].map((f) => [f.dataset.figure, f.querySelectorAll('.line').length])),
    title: document.querySelector('header b').textContent, bottom: document.querySelector('[data-figure=distance]').getBoundingClientRect().bottom <= innerHeight,
    table: document.querySelector('.changes tr:nth-child(5)').getBoundingClientRect().bottom <= document.querySelector('footer').getBoundingClientRect().top,
    visible: gaitslamPage.scene.beliefs.map(({path}) => path.object.visible), columns: gaitslamPage.scene.columns, marks: gaitslamPage.moments.partings, hash: location.hash})`);
  const rows = () =>
    browser.value(
      `[...document.querySelectorAll('.changes tbody tr')].map((row) => [...row.cells].map((cell) => cell.textContent))`
    );
  const table = await rows();
  await click(browser, '.changes th:last-child .sort');
  const sorted = await rows();
  await click(browser, '.changes tbody button');
  const worst = await browser.value('gaitslamPage.player.t');
  await browser.value('gaitslamPage.player.go(0)');
  await browser.press(']', 221);
  const marked = await read();
  // Both runs' searches are in one image, in their colors.
  await browser.value('gaitslamPage.player.go(0.5)');
  await browser.until(`${kPane}.headIndex === ${kPane}.index`);
  const image =
    await browser.value(`(() => { const {head} = gaitslamPage.panes[0], {data} = head.context.getImageData(0, 0, head.canvas.width, head.canvas.height);
    const has = (role) => { const paint = document.createElement('canvas').getContext('2d'); paint.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--' + role);
      paint.fillRect(0, 0, 1, 1); const [r, g, b] = paint.getImageData(0, 0, 1, 1).data; let count = 0;
      for (let i = 0; i < data.length; i += 4) if (Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 40) ++count; return count; };
    return {canvases: document.querySelectorAll('.head canvas').length, colors: gaitslamPage.panes.map(({role}) => has(role))}; })()`);
  // A landmark that is picked in one run is marked in the other, by its position.
  const places =
    await browser.value(`(() => { const maps = gaitslamPage.panes.map(({run, index}) => run.mapAt(index)), [id] = maps[0][0];
    gaitslamPage.landmarks.pick({run: 0, id}); const at = maps.map((map, i) => map.find(([own]) => own === gaitslamPage.panes[i].picked)?.[1]);
    return {apart: Math.hypot(...[0, 1, 2].map((k) => at[0][k] - at[1][k])), text: gaitslamPage.landmarks.text.textContent, said: gaitslamPage.landmarks.inCommon.textContent}; })()`);
  const beyond =
    await browser.value(`(() => { const [pane] = gaitslamPage.panes, {run, series} = pane; pane.show(run.frames.length - 1, 1e3);
    return {value: series.x[series.at(1e3)] ?? null, state: pane.state.textContent}; })()`);
  await click(browser, '[data-strip=nis_vision]');
  const nis = await browser.value(`document.querySelectorAll('[data-figure=nis_vision] .line').length`);
  await browser.press('v', 86);
  const differs =
    await browser.value(`(() => { const {scene} = gaitslamPage, source = scene.renderer.domElement, canvas = document.createElement('canvas'); scene.render();
    Object.assign(canvas, {width: source.width, height: source.height}); const context = canvas.getContext('2d', {willReadFrequently: true}); context.drawImage(source, 0, 0);
    const half = Math.floor(canvas.width / 2), [a, b] = [0, half].map((x) => context.getImageData(x, 0, half, canvas.height).data); let count = 0;
    for (let i = 0; i < a.length; i += 4) if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 60) ++count; return count / (a.length / 4); })()`);
  await click(browser, '[data-layer=estimate1]');
  await browser.value('gaitslamPage.setMode("orbit")');
  await browser.rest(500);
  const hidden = await read();
  await browser.send('Page.reload');
  await browser.rest(500);
  await browser.until(`document.documentElement?.dataset.model === 'true'`);
  return {
    table,
    sorted,
    worst,
    marked,
    image,
    places,
    beyond,
    nis,
    differs,
    hidden,
    again: await read(),
    width_at_400: await browser.phoneWidth(),
    said: browser.said,
    covered_at_400: await browser.value(
      `Math.max(...[...document.querySelectorAll('footer, .controls')].map((e) => (['fixed', 'sticky'].includes(getComputedStyle(e).position) ? e.offsetHeight : 0)))`
    )
  };
}

// The depth below the mouse, and the colors of a lidar's points by height and by intensity.
async function useRig(browser, url) {
  await openView(browser, url);
  await browser.value('gaitslamPage.player.go(gaitslamPage.player.duration)');
  await browser.until('gaitslamPage.rig.every(({drawn}) => drawn)');
  await browser.mouse('mouseMoved', await placeOf(browser, '.depth > canvas', 0.3));
  const depth =
    await browser.value(`(() => { const layer = gaitslamPage.rig.find(({isDepth}) => isDepth); return {at: layer.at, text: layer.value.textContent, bars: document.querySelectorAll('.bar').length,
    painted: [...layer.canvas.getContext('2d').getImageData(...layer.at, 1, 1).data]}; })()`);
  const sweep = () =>
    browser.value(`(() => { const [{geometry, material}] = gaitslamPage.scene.sweeps.values(), colors = geometry.attributes.color.array;
    return {depthTest: material.depthTest, colors: new Set(Array.from({length: colors.length / 3}, (_, i) => colors.slice(3 * i, 3 * i + 3).join())).size}; })()`);
  const byHeight = await sweep();
  await browser.value(
    `(() => { const choice = document.querySelector('.lidar select'); choice.value = 'intensity'; choice.dispatchEvent(new Event('change')); })()`
  );
  return {depth, byHeight, byIntensity: await sweep(), said: browser.said};
}

// Watches until the run has ended.
async function watch(browser, url) {
  await openView(browser, url, ` && document.documentElement.dataset.ended === 'true'`);
  return {
    ...short(await look(browser)),
    how: await browser.value('gaitslamPage.note.textContent'),
    said: browser.said
  };
}

async function picture(browser, url, seconds, file, width = 1200, height = 900, theme = 'light') {
  await browser.open(url, kReady, {width: +width, height: +height, theme});
  await browser.until(
    `document.documentElement?.dataset.model === 'true' && gaitslamPage.player.duration > ${seconds}`
  );
  if (await browser.value('!gaitslamPage.player.live')) {
    await browser.value(`gaitslamPage.player.go(${seconds})`);
    await browser.until(`${kPane}.headIndex === ${kPane}.index`);
  }
  await browser.rest(400);
  await browser.picture(file);
  return {said: browser.said};
}

const kDrawn = `document.readyState === 'complete' && +document.documentElement.dataset.figures > 0
  && document.documentElement.dataset.figures === document.documentElement.dataset.drawn`;

// The controls that the keyboard must reach, in page order.
const kReachable = `[...document.querySelectorAll('a[href], button, select, input, summary, [tabindex="0"]')]
  .filter((e) => e.offsetParent && !e.closest('details:not([open]) > :not(summary)'))`;
const kName = `((e) => e.tagName.toLowerCase() + ' ' + (e.getAttribute('aria-label') ?? e.textContent).trim())`;

// The controls that the Tab key reaches, and those without a visible focus.
async function walkThrough(browser) {
  const expected = await browser.value(`${kReachable}.map(${kName})`);
  const reached = [],
    unseen = [];
  for (let i = 0; i < expected.length; ++i) {
    await browser.press('Tab', 9);
    reached.push(await browser.value(`${kName}(document.activeElement)`));
    const outline = await browser.value(`getComputedStyle(document.activeElement).outlineStyle`);
    if (outline === 'none') unseen.push(reached.at(-1));
  }
  return {expected, reached, unseen};
}

// The dots of the runs over two metrics, before and after another one is chosen.
async function scatter(browser) {
  const see = () =>
    browser.value(
      `({title: document.querySelector('.scatter figcaption').textContent, dots: [...document.querySelectorAll('.scatter .dots')].map((path) => path.getAttribute('d'))})`
    );
  const before = await see();
  await browser.value(
    `(() => { const choice = document.querySelector('.scatter select'); choice.selectedIndex = 2; choice.dispatchEvent(new Event('change')); })()`
  );
  return {before, after: await see()};
}

// The legend of the first figure over time with and without a cursor, and the start of the axes after a
// zoom by dragging and a reset by double click.
async function point(browser) {
  const see = () =>
    browser.value(`(() => { const start = (name) => document.querySelector('[data-figure=' + name + '] svg.data').viewBox.baseVal.x;
    return {legend: document.querySelector('[data-figure=error_x] .legend').textContent, first: start('error_x'), other: start('error_yaw')}; })()`);
  const before = await see(),
    at = (part) => placeOf(browser, '[data-figure=error_x] svg', part);
  await browser.mouse('mouseMoved', await at(0.6));
  const under = await see();
  await browser.drag(await at(0.3), await at(0.5));
  const zoomed = await see();
  for (const count of [1, 2]) await browser.click(await at(0.6), count);
  return {before, under, zoomed, whole: await see()};
}

// On A4 paper with margins of one centimeter: 718 px wide.
async function print(browser) {
  await browser.value(`dispatchEvent(new Event('beforeprint'))`);
  await browser.send('Emulation.setEmulatedMedia', {
    media: 'print',
    features: [{name: 'prefers-color-scheme', value: 'dark'}]
  });
  await browser.send('Emulation.setDeviceMetricsOverride', {
    width: 718,
    height: 1047,
    deviceScaleFactor: 1,
    mobile: false
  });
  await browser.rest(500);
  return browser.value(`(() => {
    const all = (selector) => [...document.querySelectorAll(selector)].filter((e) => e.getClientRects().length > 0);
    const name = (e) => (e.closest('[data-figure]')?.dataset.figure ?? e.closest('section')?.id) + ' ' + e.tagName;
    const dark = (e) => {
      const [red, green, blue, alpha] = getComputedStyle(e).backgroundColor.match(/[\\d.]+/g).map(Number);
      return alpha !== 0 && red + green + blue < 600;
    };
    const box = (e) => e.getBoundingClientRect();
    return {
      background: getComputedStyle(document.body).backgroundColor,
      dark: all('body, figure, .card, pre, td, th').filter(dark).map(name),
      controls: all('nav, .controls, input, select, button:not(.sort, .legend button)').map(name),
      cut: all('figure, figure canvas, figure svg, table, pre').filter((e) => box(e).right > innerWidth + 1 || box(e).left < -1).map(name),
      too_high: all('figure').filter((e) => box(e).height > innerHeight).map(name),
      closed: document.querySelectorAll('details:not([open])').length,
    };
  })()`);
}

// The page of a report of several runs with keyboard, mouse and printer, on a dark screen.
async function useReport(browser, page) {
  await browser.open('file://' + path.resolve(page), kDrawn, {theme: 'dark'});
  await browser.send('Emulation.clearDeviceMetricsOverride');
  const keyboard = await walkThrough(browser);
  return {
    keyboard,
    scatter: await scatter(browser),
    pointed: await point(browser),
    phone: await browser.phoneWidth(),
    print: await print(browser)
  };
}

// By page: serious findings of axe-core in the light and dark themes, and the width on the narrowest phone.
// folder: contains node_modules.
async function audit(browser, pages, folder) {
  const axe = fs.readFileSync(path.join(folder, 'node_modules/axe-core/axe.min.js'), 'utf8'),
    found = {};
  for (const page of pages.split(' ')) {
    await browser.open(
      ...(page.startsWith('http')
        ? [page, kReady]
        : ['file://' + path.resolve(page), `document.readyState === 'complete'`])
    );
    await browser.value(`${axe};0`);
    found[page] = {findings: []};
    for (const theme of ['light', 'dark']) {
      await browser.send('Emulation.setEmulatedMedia', {
        features: [{name: 'prefers-color-scheme', value: theme}]
      });
      found[page].findings.push(
        ...(await browser.value(
          `axe.run({resultTypes: ['violations']}).then(({violations}) => violations.filter(({impact}) => ['serious', 'critical'].includes(impact))
        .map(({id, nodes}) => '${theme}: ' + id + ': ' + nodes[0].html.slice(0, 200)))`,
          true
        ))
      );
    }
    found[page].width = await browser.phoneWidth(360);
  }
  return found;
}

const [what, url, profile, ...more] = process.argv.slice(2);
const uses = {
  live: useLive,
  playback: usePlayback,
  keys: useKeys,
  values: readValues,
  compare,
  rig: useRig,
  watch,
  picture,
  report: useReport,
  audit
};
say(profile, (browser) => uses[what](browser, url, ...more));
