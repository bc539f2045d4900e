// Uses the page of a report with keyboard and printer, in headless Chromium on a dark screen, and prints the findings as one
// JSON object. Usage: node use_report.cjs PAGE_OF_SEVERAL_RUNS.html PROFILE_FOLDER
const path = require('path');
const {say} = require('./browser.cjs');

const kDrawn = `document.readyState === 'complete' && +document.documentElement.dataset.figures > 0
  && document.documentElement.dataset.figures === document.documentElement.dataset.drawn`;

// The controls that the keyboard must reach, in the order of the page.
const kReachable = `[...document.querySelectorAll('a[href], button, select, input, summary, [tabindex="0"]')]
  .filter((e) => e.offsetParent && !e.closest('details:not([open]) > :not(summary)'))`;
const kName = `((e) => e.tagName.toLowerCase() + ' ' + (e.getAttribute('aria-label') ?? e.textContent).trim())`;

// The controls that the Tab key reaches, and those without a visible focus.
async function walkThrough(browser) {
  const expected = await browser.value(`${kReachable}.map(${kName})`);
  const reached = [], unseen = [];
  for (let i = 0; i < expected.length; ++i) {
    await browser.press('Tab', 9);
    reached.push(await browser.value(`${kName}(document.activeElement)`));
    const outline = await browser.value(`getComputedStyle(document.activeElement).outlineStyle`);
    if (outline === 'none') unseen.push(reached.at(-1));
  }
  return {expected, reached, unseen};
}

async function moveTime(browser) {
  const see = () => browser.value(`({t: document.querySelector('output').textContent,
    picture: document.querySelector('.scene canvas').toDataURL()})`);
  const last = await see();
  await browser.value(`document.querySelector('.controls input[type=range]').focus()`);
  for (let i = 0; i < 5; ++i) await browser.press('ArrowLeft', 37);
  const earlier = await see();
  await browser.value(`document.querySelector('.scene').focus()`);
  for (let i = 0; i < 5; ++i) await browser.press('ArrowLeft', 37);
  const turned = await see();
  return {last_s: parseFloat(last.t), earlier_s: parseFloat(earlier.t), moved: last.picture !== earlier.picture,
    turned: earlier.picture !== turned.picture};
}

// The legend of the first figure over time with and without a cursor, the instant of a click, and the start of the axes after a
// zoom by dragging and a reset by double click.
async function point(browser) {
  const see = () => browser.value(`(() => { const at = (name) => document.querySelector('[data-figure=' + name + ']');
    const start = (name) => at(name).querySelector('svg.data').viewBox.baseVal.x, holder = at('error_x');
    return {legend: holder.querySelector('.legend').textContent, instant: holder.querySelector('.instant').textContent,
      first: start('error_x'), other: start('error_yaw')}; })()`);
  const before = await see();
  const box = await browser.value(`(() => { const plot = document.querySelector('[data-figure=error_x] svg');
    plot.scrollIntoView({block: 'center'}); const {x, y, width, height} = plot.getBoundingClientRect(); return {x, y, width, height}; })()`);
  const mouse = (type, part, more = {}) => browser.send('Input.dispatchMouseEvent', {type, x: box.x + part * box.width, y: box.y + 0.4 * box.height, ...more});
  const button = (type, part, clickCount = 1) => mouse(type, part, {button: 'left', clickCount});
  await mouse('mouseMoved', 0.6);
  const under = await see();
  await button('mousePressed', 0.6);
  await button('mouseReleased', 0.6);
  const clicked = await see();
  await button('mousePressed', 0.3);
  await mouse('mouseMoved', 0.5, {button: 'left', buttons: 1});
  await button('mouseReleased', 0.5);
  const zoomed = await see();
  for (const count of [1, 2]) {
    await button('mousePressed', 0.6, count);
    await button('mouseReleased', 0.6, count);
  }
  return {before, under, clicked, zoomed, whole: await see()};
}

// On paper of A4 with margins of a centimeter: 718 px wide.
async function print(browser) {
  await browser.value(`dispatchEvent(new Event('beforeprint'))`);
  await browser.send('Emulation.setEmulatedMedia', {media: 'print', features: [{name: 'prefers-color-scheme', value: 'dark'}]});
  await browser.send('Emulation.setDeviceMetricsOverride', {width: 718, height: 1047, deviceScaleFactor: 1, mobile: false});
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
      controls: all('nav, .controls, input, select, button').map(name),
      cut: all('figure, figure canvas, figure svg, table, pre').filter((e) => box(e).right > innerWidth + 1 || box(e).left < -1).map(name),
      too_high: all('figure').filter((e) => box(e).height > innerHeight).map(name),
      closed: document.querySelectorAll('details:not([open])').length,
    };
  })()`);
}

async function use(browser, page) {
  await browser.open('file://' + path.resolve(page), kDrawn, {theme: 'dark'});
  await browser.send('Emulation.clearDeviceMetricsOverride');
  const keyboard = await walkThrough(browser);
  return {keyboard, map: await moveTime(browser), pointed: await point(browser), phone: await browser.phoneWidth(), print: await print(browser)};
}

const [page, profile] = process.argv.slice(2);
say(profile, (browser) => use(browser, page));
