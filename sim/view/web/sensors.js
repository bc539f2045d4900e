// The head camera's image with the filter's searches, and the robot's additional cameras and lidars.
import {choice, color, element} from '../../pages/web/dom.js';
import {kOutcomes} from './run.js';
import {Stored, picture} from './source.js';

const kPatch = 11,
  kScale = 2;
const kNew = '#5aa9ff';

export class HeadView {
  constructor(run, name) {
    const {width, height} = run.camera;
    Object.assign(this, {width, height});
    this.canvas = element('canvas', {
      width: kScale * width,
      height: kScale * height,
      role: 'img',
      'aria-label': `image of the head camera${name ? `, ${name}` : ''}`
    });
    // Kept in memory, so that it does not wait for the scene.
    this.context = this.canvas.getContext('2d', {willReadFrequently: true});
  }

  /// image: something a canvas can draw, or null. runs: {frame, role, picked} for each run; with several
  /// runs, searches have their colors. isLost: the image did not reach the filter.
  show(image, runs, isLost) {
    const {context} = this;
    context.setTransform(kScale, 0, 0, kScale, 0, 0);
    if (image) {
      context.drawImage(image, 0, 0, this.width, this.height);
    } else {
      context.fillStyle = color('panel');
      context.fillRect(0, 0, this.width, this.height);
      context.fillStyle = color('soft');
      context.font = '12px sans-serif';
      context.fillText('no image', 8, 20);
    }
    if (isLost) this.strike();
    context.translate(0.5, 0.5);
    for (const [i, {frame, role, picked}] of runs.entries()) {
      // Thicker lines first, so that they remain visible behind later ones.
      context.lineWidth = 1.2 + 1.8 * (runs.length - 1 - i);
      for (const search of frame.searches ?? []) this.search(search, runs.length > 1 ? color(role) : null);
      const marked = picked !== null && frame.searches?.find(([id]) => id === picked);
      if (marked) this.ring(marked[1], marked[2]);
      context.strokeStyle = kNew;
      for (const [u, v] of frame.new ?? []) this.square(u, v);
    }
  }

  search([, u, v, a, b, angle, outcome, foundU, foundV], ownColor) {
    const {context} = this;
    context.strokeStyle = ownColor ?? kOutcomes[outcome];
    context.setLineDash(outcome === 'missed' ? [3, 3] : []);
    context.beginPath();
    context.ellipse(u, v, a, b, angle, 0, 2 * Math.PI);
    context.stroke();
    context.setLineDash([]);
    if (outcome === 'found') this.square(foundU, foundV);
    if (outcome === 'rejected') this.cross(foundU, foundV);
  }

  strike() {
    const {context, width, height} = this;
    context.fillStyle = '#0009';
    context.fillRect(0, 0, width, height);
    Object.assign(context, {
      strokeStyle: '#ff5c5c',
      lineWidth: 3,
      fillStyle: '#fff',
      font: '12px sans-serif'
    });
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(width, height);
    context.moveTo(width, 0);
    context.lineTo(0, height);
    context.stroke();
    context.fillText('lost: the filter got no image', 8, 20);
  }

  ring(u, v) {
    const {context} = this;
    for (const [style, width] of [
      ['#000', 5],
      ['#fff', 2.5]
    ]) {
      Object.assign(context, {strokeStyle: style, lineWidth: width});
      context.strokeRect(u - kPatch, v - kPatch, 2 * kPatch, 2 * kPatch);
    }
  }

  /// The searched landmark nearest to a position on the page, and its distance (px): {id, far}; id: absent if
  /// none is near.
  pick({clientX, clientY}, {searches}) {
    const {left, top, width} = this.canvas.getBoundingClientRect(),
      scale = this.width / width;
    const far = ([, u, v]) => Math.hypot(u - scale * (clientX - left), v - scale * (clientY - top));
    const nearest = [...(searches ?? [])].sort((a, b) => far(a) - far(b))[0];
    return nearest && far(nearest) < 1.5 * kPatch ? {id: nearest[0], far: far(nearest)} : {far: Infinity};
  }

  square(u, v) {
    this.context.strokeRect(u - kPatch / 2, v - kPatch / 2, kPatch, kPatch);
  }

  cross(u, v) {
    const {context} = this,
      d = kPatch / 2;
    context.beginPath();
    context.moveTo(u - d, v - d);
    context.lineTo(u + d, v + d);
    context.moveTo(u - d, v + d);
    context.lineTo(u + d, v - d);
    context.stroke();
  }
}

export function grayPicture(bytes, width, height) {
  const pixels = new ImageData(width, height),
    words = new Uint32Array(pixels.data.buffer);
  for (let i = 0; i < words.length; ++i) words[i] = 0xff000000 | (bytes[i] * 0x010101);
  const canvas = element('canvas', {width, height});
  canvas.getContext('2d').putImageData(pixels, 0, 0);
  return canvas;
}

const points = async (blob) => new Float32Array(await blob.arrayBuffer());

/// Depth: width and height (uint32), then mm row by row (uint16; 0: none).
async function depths(blob) {
  const buffer = await blob.arrayBuffer(),
    [width, height] = new Uint32Array(buffer, 0, 2);
  return {width, height, mm: new Uint16Array(buffer, 8)};
}

// Options for coloring lidar points.
const kColoring = {height: {low: 0, high: 2.5, unit: 'm'}, intensity: {low: 0, high: 1, unit: ''}};

/// An additional camera or lidar: shows its reading at the displayed frame while its switch is on.
export class RigLayer {
  constructor(run, sensor, number, scene) {
    const isLidar = sensor.kind === 'lidar',
      isDepth = sensor.kind === 'depth';
    Object.assign(this, {
      run,
      isDepth,
      name: sensor.name,
      scene: isLidar ? scene : null,
      palette: run.about.palette,
      scale: isDepth ? {low: sensor.range[0], high: sensor.range[1], unit: 'm'} : kColoring.height
    });
    this.stored = new Stored(
      `/rig/${run.index}/${number}`,
      isLidar ? points : isDepth ? depths : picture,
      100
    );
    this.canvas = isLidar
      ? null
      : element('canvas', {width: 0, height: 0, role: 'img', 'aria-label': `image of ${sensor.name}`});
    this.on = element('input', {type: 'checkbox', checked: '', onchange: () => this.show(this.index)});
    this.bar = element('p', {class: 'soft'});
    this.value = element('span', {class: 'soft', role: 'status'});
    const colors = Object.keys(kColoring).map((name) => [name, `by ${name}`]);
    const by = isLidar
      ? choice(`color of ${sensor.name}`, colors, (name) => this.color(kColoring[name]))
      : null;
    this.element = element(
      'figure',
      {class: sensor.kind},
      element(
        'label',
        {class: 'key'},
        this.on,
        element('b', {}, sensor.name),
        isDepth ? 'depth; black: none' : sensor.kind
      ),
      by,
      this.canvas,
      this.bar,
      this.value
    );
    if (isDepth || isLidar) this.color(this.scale);
    if (isDepth)
      this.canvas.addEventListener('pointermove', (event) => {
        this.at = this.pixelAt(event);
        this.read();
      });
    if (isDepth)
      this.canvas.addEventListener('pointerleave', () => {
        this.at = null;
        this.read();
      });
  }

  color(scale) {
    const bar = element('canvas', {width: 256, height: 1, class: 'bar'}),
      context = bar.getContext('2d'),
      text = (value) => `${value} ${scale.unit}`.trim();
    this.scale = scale;
    for (let i = 0; i < 256; ++i) {
      context.fillStyle = `rgb(${this.palette.slice(3 * i, 3 * i + 3).join()})`;
      context.fillRect(i, 0, 1, 1);
    }
    this.bar.replaceChildren(text(scale.low), bar, text(scale.high));
    if (this.drawn) this.draw(this.drawn);
  }

  /// The index of a value's color in the palette.
  level(value) {
    return (
      3 *
      Math.round(
        255 * Math.min(1, Math.max(0, (value - this.scale.low) / (this.scale.high - this.scale.low)))
      )
    );
  }

  pixelAt({clientX, clientY}) {
    const {left, top, width, height} = this.canvas.getBoundingClientRect();
    return [
      Math.floor(((clientX - left) / width) * this.canvas.width),
      Math.floor(((clientY - top) / height) * this.canvas.height)
    ];
  }

  read() {
    const {at, drawn} = this,
      mm = at && drawn ? drawn.mm[at[1] * drawn.width + at[0]] : undefined;
    this.value.textContent =
      mm === undefined ? '' : ` at ${at.join(', ')}: ${mm ? `${mm / 1000} m` : 'none'}`;
  }

  /// Shows a frame's reading. Frames may pass while it is being fetched; then the newest one is fetched next.
  async show(index) {
    this.index = index;
    const number = this.run.frames[index]?.rig;
    if (!this.on.checked || number === undefined) return this.draw(null);
    if (this.isFetching) return;
    this.isFetching = true;
    const content = await this.stored.at(number).catch(() => null);
    this.isFetching = false;
    if (this.on.checked) this.draw(content);
    if (this.index !== index) this.show(this.index);
  }

  draw(content) {
    this.drawn = content;
    if (this.scene)
      return this.scene.showSweep(this.name, content, (height, intensity) => {
        const at = this.level(this.scale === kColoring.height ? height : intensity);
        return [this.palette[at] / 255, this.palette[at + 1] / 255, this.palette[at + 2] / 255];
      });
    this.canvas.hidden = !content;
    if (!content) return undefined;
    Object.assign(this.canvas, {width: content.width, height: content.height});
    const context = this.canvas.getContext('2d');
    if (!this.isDepth) return context.drawImage(content, 0, 0);
    const pixels = context.createImageData(content.width, content.height);
    content.mm.forEach((mm, i) => {
      const at = this.level(mm / 1000);
      pixels.data.set(
        mm ? [this.palette[at], this.palette[at + 1], this.palette[at + 2], 255] : [0, 0, 0, 255],
        4 * i
      );
    });
    context.putImageData(pixels, 0, 0);
    return this.read();
  }
}
