// Uses the view as somebody at a browser does, in headless Chromium, and says what was found as one JSON object.
// Usage: node use_view.cjs live|playback|watch|picture URL PROFILE_FOLDER [SECONDS [PICTURE [WIDTH HEIGHT [light|dark]]]]
const {spawn} = require('child_process');
const fs = require('fs');

// The browser is told what to do through a pipe: messages of JSON with a zero byte after each.
class Browser {
  constructor(profile) {
    this.process = spawn('chromium', ['--headless', '--no-sandbox', `--user-data-dir=${profile}`, '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader', '--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1', '--window-size=1200,900',
      '--remote-debugging-pipe', 'about:blank'],
    {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});
    this.waiting = new Map();
    this.said = [];
    this.sent = 0;
    let rest = '';
    this.process.stdio[4].setEncoding('utf8').on('data', (chunk) => {
      const messages = (rest + chunk).split('\0');
      rest = messages.pop();
      messages.map((text) => JSON.parse(text)).forEach((message) => this.take(message));
    });
  }

  take({id, method, params, ...answer}) {
    if (id) this.waiting.get(id)?.(answer);
    if (method === 'Runtime.consoleAPICalled') this.said.push(`${params.type}: ${params.args.map((a) => a.value ?? a.description).join(' ')}`);
    if (method === 'Runtime.exceptionThrown') this.said.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    // What Chromium says of its own software renderer is not the page's.
    if (method === 'Log.entryAdded' && params.entry.level !== 'info' && !params.entry.text.includes('GPU stall')) this.said.push(params.entry.text);
  }

  send(method, params = {}) {
    const id = ++this.sent;
    this.process.stdio[3].write(JSON.stringify({id, method, params, sessionId: this.session}) + '\0');
    return new Promise((resolve, reject) => this.waiting.set(id, ({result, error}) => {
      this.waiting.delete(id);
      if (error) reject(new Error(`${method}: ${error.message}`));
      else resolve(result);
    }));
  }

  async open(url, width = 1200, height = 900, theme = 'light') {
    const {targetId} = await this.send('Target.createTarget', {url: 'about:blank'});
    this.session = (await this.send('Target.attachToTarget', {targetId, flatten: true})).sessionId;
    await this.send('Runtime.enable');
    await this.send('Log.enable');
    await this.send('Emulation.setDeviceMetricsOverride', {width, height, deviceScaleFactor: 1, mobile: false});
    await this.send('Emulation.setEmulatedMedia', {features: [{name: 'prefers-color-scheme', value: theme}]});
    const begun = Date.now();
    await this.send('Page.navigate', {url});
    await this.until(`document.documentElement?.dataset.ready === 'true'`);
    this.ready_ms = Date.now() - begun;
  }

  async value(expression, awaitPromise = false) {
    const {result, exceptionDetails} = await this.send('Runtime.evaluate', {expression, returnByValue: true, awaitPromise});
    if (exceptionDetails) throw new Error(exceptionDetails.exception.description);
    return result.value;
  }

  async until(expression, ms = 120000) {
    for (const end = Date.now() + ms; Date.now() < end; await this.rest(20)) if (await this.value(expression)) return;
    throw new Error(`never came true: ${expression}; the page said: ${this.said.join('; ')}; ${await this.value('document.body.innerText.slice(0, 400)')}`);
  }

  rest(ms) { return new Promise((resolve) => setTimeout(resolve, ms)); }

  async press(key, code) {
    const text = key.length === 1 ? key : undefined;
    await this.send('Input.dispatchKeyEvent', {type: 'keyDown', key, code: key, windowsVirtualKeyCode: code, text});
    await this.send('Input.dispatchKeyEvent', {type: 'keyUp', key, code: key, windowsVirtualKeyCode: code});
  }

  async picture(file) {
    const {data} = await this.send('Page.captureScreenshot', {format: 'png'});
    fs.writeFileSync(file, Buffer.from(data, 'base64'));
  }
}

const kPane = 'gaitslamPage.panes[0]', kFrame = `${kPane}.run.frames[${kPane}.index]`;
const look = (browser) => browser.value(`({t: gaitslamPage.t, frames: ${kPane}.run.frames.length, robot: ${kFrame}.bodies?.slice(0, 3),
  bodies: ${kPane}.scene.bodies.filter((b) => b.visible).length, ellipsoids: ${kPane}.scene.shownEllipsoids,
  picture: ${kPane}.scene.renderer.domElement.toDataURL().length, space: ${kPane}.scene.renderer.domElement.toDataURL(),
  head: ${kPane}.head.canvas.toDataURL(), state: ${kPane}.state.textContent, counts: ${kPane}.counts.textContent, play: gaitslamPage.play.textContent})`);
const short = ({space, head, ...rest}) => rest;

async function useLive(browser, url) {
  await browser.open(url);
  await browser.until(`document.documentElement?.dataset.model === 'true'`);
  await browser.press('4', 52);  // slowly: what follows takes a busy machine some time, and the walk is short
  const first = await look(browser);
  await browser.until(`gaitslamPage.t > ${first.t} + 1 && ${kPane}.scene.shownEllipsoids > 5`);
  const later = await look(browser);
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
  return {first: short(first), later: short(later), space_changed: first.space !== later.space, head_changed: first.head !== later.head,
    paused_frames: still - paused, stepped_frames: stepped - still, how: await browser.value('gaitslamPage.note.textContent'), said: browser.said};
}

// The position of the camera in the 3D view, and which image the head view shows.
const kPlaces = `({t: gaitslamPage.t, index: ${kPane}.index, head: ${kPane}.headIndex, truth: ${kFrame}.truth.slice(0, 3),
  frustum: ${kPane}.scene.frusta.truth.position.toArray(), slider: +gaitslamPage.slider.value})`;

// How the 3D view through the camera correlates with the head image of its own instant, and with that of 5 s before. In the page.
const agreement = async (seconds) => {
  const page = globalThis.gaitslamPage, [pane] = page.panes, columns = 40, rows = 30;
  const grey = (source, x, width, height) => {
    const canvas = new OffscreenCanvas(columns, rows), context = canvas.getContext('2d');
    context.filter = 'blur(1px)';
    context.drawImage(source, x, 0, width, height, 0, 0, columns, rows);
    const {data} = context.getImageData(0, 0, columns, rows);
    return Array.from({length: columns * rows}, (_, i) => data[4 * i] + data[4 * i + 1] + data[4 * i + 2]);
  };
  const correlation = (a, b) => {
    const mean = (list) => list.reduce((s, v) => s + v, 0) / list.length, ma = mean(a), mb = mean(b);
    const sum = (f) => a.reduce((s, _, i) => s + f(a[i] - ma, b[i] - mb), 0);
    return sum((p, q) => p * q) / Math.sqrt(sum((p) => p * p) * sum((_, q) => q * q));
  };
  const imageAt = async (t) => { const image = await pane.images.at(pane.run.indexAt(t)); return grey(image, 0, image.width, image.height); };
  page.go(seconds);
  const before = page.mode;
  page.setMode('head');
  const space = pane.scene.renderer.domElement, wide = space.height * 4 / 3;
  for (const name of ['points', 'ellipsoids', 'own']) pane.scene[name].visible = false;
  pane.scene.draw();
  const seen = grey(space, (space.width - wide) / 2, wide, space.height);
  const found = {own: correlation(seen, await imageAt(seconds)), earlier: correlation(seen, await imageAt(Math.max(0, seconds - 5)))};
  for (const name of ['points', 'ellipsoids', 'own']) pane.scene[name].visible = true;
  page.setMode(before);
  return found;
};

async function usePlayback(browser, url, seconds) {
  await browser.open(url);
  const ready_ms = browser.ready_ms;
  await browser.until(`document.documentElement?.dataset.model === 'true'`);
  const start = await look(browser);
  await browser.value(`(gaitslamPage.slider.value = ${seconds}, gaitslamPage.slider.dispatchEvent(new Event('input')))`);
  await browser.until(`${kPane}.headIndex === ${kPane}.index`);
  const scrubbed = await browser.value(kPlaces), there = await look(browser);
  await browser.value(`location.hash = '#t=${seconds}'`);
  await browser.until(`${kPane}.headIndex === ${kPane}.index && Math.abs(gaitslamPage.t - ${seconds}) < 0.001`);
  const linked = await browser.value(kPlaces);
  await browser.press('ArrowRight', 39);
  const next = await browser.value(kPlaces);
  const agree = await browser.value(`(${agreement})(${seconds})`, true);
  const moments = await browser.value(`[...document.querySelectorAll('.moment')].map((b) => b.textContent)`);
  await browser.press('c', 67);
  const through = await browser.value(`gaitslamPage.mode`);
  await browser.send('Emulation.setDeviceMetricsOverride', {width: 400, height: 800, deviceScaleFactor: 1, mobile: false});
  await browser.rest(300);
  const wide = await browser.value('document.documentElement.scrollWidth');
  return {ready_ms, start: short(start), there: short(there), scrubbed, linked, next, moments, agree, through, width_at_400: wide,
    space_changed: start.space !== there.space, head_changed: start.head !== there.head, said: browser.said,
    panes: await browser.value('gaitslamPage.panes.length')};
}

// Looks on until the run has ended.
async function watch(browser, url) {
  await browser.open(url);
  await browser.until(`document.documentElement?.dataset.ended === 'true' && document.documentElement.dataset.model === 'true'`, 120000);
  return {...short(await look(browser)), how: await browser.value('gaitslamPage.note.textContent'), said: browser.said};
}

async function picture(browser, url, [seconds, file, width, height, theme]) {
  await browser.open(url, +(width ?? 1200), +(height ?? 900), theme);
  await browser.until(`document.documentElement?.dataset.model === 'true' && gaitslamPage.duration > ${seconds}`);
  if (await browser.value('!gaitslamPage.live')) {
    await browser.value(`gaitslamPage.go(${seconds})`);
    await browser.until(`${kPane}.headIndex === ${kPane}.index`);
  }
  await browser.rest(400);
  await browser.picture(file);
  return {said: browser.said};
}

async function main() {
  const [what, url, profile, ...more] = process.argv.slice(2);
  const browser = new Browser(profile);
  try {
    const use = {live: () => useLive(browser, url), playback: () => usePlayback(browser, url, +more[0]), watch: () => watch(browser, url), picture: () => picture(browser, url, more)}[what];
    console.log(JSON.stringify(await use()));
  } finally {
    browser.process.kill();
  }
}

main().catch((error) => { console.error(error); process.exit(1); });
