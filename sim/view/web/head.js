// The image of the head camera with what the filter searched for in it.
import {color, element} from '../../pages/web/dom.js';
import {kOutcomes} from '../../pages/web/run.js';

const kPatch = 11, kScale = 2;
const kNew = '#5aa9ff';

export class HeadView {
  constructor(run) {
    const {width, height} = run.camera;
    Object.assign(this, {width, height, shown: -1});
    this.canvas = element('canvas', {width: kScale * width, height: kScale * height, role: 'img', 'aria-label': 'image of the head camera'});
    this.context = this.canvas.getContext('2d');
  }

  /// image: something a canvas can draw, or null.
  show(frame, image) {
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
    context.translate(0.5, 0.5);
    context.lineWidth = 1.2;
    for (const search of frame.searches ?? []) this.search(search);
    context.strokeStyle = kNew;
    for (const [u, v] of frame.new ?? []) this.square(u, v);
  }

  search([, u, v, a, b, angle, outcome, foundU, foundV]) {
    const {context} = this;
    context.strokeStyle = kOutcomes[outcome];
    context.setLineDash(outcome === 'missed' ? [3, 3] : []);
    context.beginPath();
    context.ellipse(u, v, a, b, angle, 0, 2 * Math.PI);
    context.stroke();
    context.setLineDash([]);
    if (outcome === 'found') this.square(foundU, foundV);
    if (outcome === 'rejected') this.cross(foundU, foundV);
  }

  square(u, v) { this.context.strokeRect(u - kPatch / 2, v - kPatch / 2, kPatch, kPatch); }

  cross(u, v) {
    const {context} = this, d = kPatch / 2;
    context.beginPath();
    context.moveTo(u - d, v - d); context.lineTo(u + d, v + d);
    context.moveTo(u - d, v + d); context.lineTo(u + d, v - d);
    context.stroke();
  }
}

/// A picture of grey bytes.
export function greyPicture(bytes, width, height) {
  const pixels = new ImageData(width, height), words = new Uint32Array(pixels.data.buffer);
  for (let i = 0; i < words.length; ++i) words[i] = 0xff000000 | bytes[i] * 0x010101;
  const canvas = element('canvas', {width, height});
  canvas.getContext('2d').putImageData(pixels, 0, 0);
  return canvas;
}
