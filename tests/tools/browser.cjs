// Headless Chromium for scripts that use a page like a reader. Only 127.0.0.1 can be reached.
const {spawn} = require('child_process');
const fs = require('fs');

// Commands go through a pipe as JSON messages, each ending with a zero byte.
class Browser {
  constructor(profile) {
    this.process = spawn(
      'chromium',
      [
        '--headless',
        '--no-sandbox',
        `--user-data-dir=${profile}`,
        '--use-angle=swiftshader',
        '--enable-unsafe-swiftshader',
        '--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1',
        '--window-size=1200,900',
        '--remote-debugging-pipe',
        'about:blank'
      ],
      {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']}
    );
    this.longest_ms = 120000; // of a wait
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
    if (method === 'Runtime.consoleAPICalled')
      this.said.push(`${params.type}: ${params.args.map((a) => a.value ?? a.description).join(' ')}`);
    if (method === 'Runtime.exceptionThrown')
      this.said.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    // Warnings about Chromium's software renderer do not come from the page.
    if (
      method === 'Log.entryAdded' &&
      params.entry.level !== 'info' &&
      !params.entry.text.includes('GPU stall')
    )
      this.said.push(params.entry.text);
  }

  send(method, params = {}) {
    const id = ++this.sent;
    this.process.stdio[3].write(JSON.stringify({id, method, params, sessionId: this.session}) + '\0');
    return new Promise((resolve, reject) =>
      this.waiting.set(id, ({result, error}) => {
        this.waiting.delete(id);
        if (error) reject(new Error(`${method}: ${error.message}`));
        else resolve(result);
      })
    );
  }

  async open(url, ready, {width = 1200, height = 900, theme = 'light'} = {}) {
    const {targetId} = await this.send('Target.createTarget', {url: 'about:blank'});
    this.session = (await this.send('Target.attachToTarget', {targetId, flatten: true})).sessionId;
    await this.send('Runtime.enable');
    await this.send('Log.enable');
    await this.resize(width, height);
    await this.send('Emulation.setEmulatedMedia', {features: [{name: 'prefers-color-scheme', value: theme}]});
    await this.send('Page.navigate', {url});
    await this.when(ready);
  }

  async value(expression) {
    const request = {expression, returnByValue: true, awaitPromise: true};
    const {result, exceptionDetails} = await this.send('Runtime.evaluate', request);
    if (exceptionDetails) throw new Error(exceptionDetails.exception.description);
    return result.value;
  }

  /// The value of a function that runs in the page.
  call(action, ...values) {
    return this.value(`(${action})(${values.map((value) => JSON.stringify(value)).join()})`);
  }

  /// Waits until a function in the page returns true. The page may reload itself in the meantime.
  async when(condition, ...values) {
    const isReload = ({message}) => message === 'Runtime.evaluate: Inspected target navigated or closed';
    const orFalse = (error) => (isReload(error) ? false : Promise.reject(error));
    for (const end = Date.now() + this.longest_ms; Date.now() < end; await this.rest(20))
      if (await this.call(condition, ...values).catch(orFalse)) return;
    const text = await this.value('document.body.innerText.slice(0, 400)');
    throw new Error(`never came true: ${condition}; the page said: ${this.said.join('; ')}; ${text}`);
  }

  rest(ms) {
    return new Promise((resolve) => setTimeout(resolve, ms));
  }

  async press(key, code) {
    const text = key === 'Enter' ? '\r' : key.length === 1 ? key : undefined;
    await this.send('Input.dispatchKeyEvent', {
      type: 'keyDown',
      key,
      code: key,
      windowsVirtualKeyCode: code,
      text
    });
    await this.send('Input.dispatchKeyEvent', {type: 'keyUp', key, code: key, windowsVirtualKeyCode: code});
  }

  mouse(type, place, more = {}) {
    return this.send('Input.dispatchMouseEvent', {type, ...place, ...more});
  }

  // clickCount 2: the second click of a double click.
  async click(place, clickCount = 1) {
    for (const type of ['mousePressed', 'mouseReleased'])
      await this.mouse(type, place, {button: 'left', clickCount});
  }

  async drag(from, to, at = () => null) {
    await this.mouse('mousePressed', from, {button: 'left', clickCount: 1});
    await this.mouse('mouseMoved', to, {button: 'left', buttons: 1});
    const found = await at();
    await this.mouse('mouseReleased', to, {button: 'left', clickCount: 1});
    return found;
  }

  resize(width, height) {
    const metrics = {width, height, deviceScaleFactor: 1, mobile: false};
    return this.send('Emulation.setDeviceMetricsOverride', metrics);
  }

  async phoneWidth(width = 400) {
    await this.resize(width, 800);
    await this.rest(500);
    return this.value('document.documentElement.scrollWidth');
  }

  async picture(file) {
    const {data} = await this.send('Page.captureScreenshot', {format: 'png'});
    fs.writeFileSync(file, Buffer.from(data, 'base64'));
  }
}

// Prints what use(browser) found as one JSON object.
async function say(profile, use) {
  const browser = new Browser(profile);
  try {
    console.log(JSON.stringify(await use(browser)));
  } catch (error) {
    console.error(error);
    process.exitCode = 1;
  } finally {
    browser.process.kill();
  }
}

module.exports = {say};
