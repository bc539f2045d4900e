// A further camera or lidar of the robot: what it measured at the shown frame, while its switch is on.
import {element} from '../../pages/web/dom.js';
import {Stored, picture} from './source.js';

const points = async (blob) => new Float32Array(await blob.arrayBuffer());

export class RigLayer {
  constructor(run, sensor, number, scene) {
    const isLidar = sensor.kind === 'lidar';
    Object.assign(this, {run, name: sensor.name, scene: isLidar ? scene : null, isShown: sensor.kind !== 'imu' && (!isLidar || Boolean(scene))});
    this.stored = new Stored(`/rig/${run.index}/${number}`, isLidar ? points : picture, 100);
    this.canvas = isLidar ? null : element('canvas', {width: 0, height: 0, role: 'img', 'aria-label': `image of ${sensor.name}`});
    this.on = element('input', {type: 'checkbox', checked: '', onchange: () => this.show(this.index)});
    this.element = element('figure', {class: sensor.kind}, element('label', {class: 'key'}, this.on, element('b', {}, sensor.name), sensor.words), this.canvas);
  }

  /// While an element is fetched, frames may pass; then the newest is fetched.
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
    if (this.scene) return this.scene.showSweep(this.name, content);
    this.canvas.hidden = !content;
    if (!content) return undefined;
    Object.assign(this.canvas, {width: content.width, height: content.height});
    return this.canvas.getContext('2d').drawImage(content, 0, 0);
  }
}
