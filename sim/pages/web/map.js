// The map of a run in a report: the scene of the view with a slider over time.
import {element} from './dom.js';
import {Run} from './run.js';
import {Scene} from './scene.js';

const scenes = [];

function draw(holder) {
  const run = new Run({sole: [0, 0, 0, 0]}, 0);
  for (const frame of JSON.parse(document.getElementById(holder.dataset.frames).textContent)) run.append(frame);
  const scene = new Scene(run, 'orbit'), last = run.frames.length - 1, time = element('output');
  const show = (index) => { time.textContent = `${run.frames[index].t.toFixed(1)} s`; scene.show(index); };
  const slider = element('input', {type: 'range', min: 0, max: last, value: last, 'aria-label': 'time', oninput: () => show(+slider.value)});
  holder.append(scene.element, element('div', {class: 'controls'}, 'time', slider, time));
  scene.lookAtPath();
  show(last);
  scenes.push(scene);
}

/// Draws the maps of the run that is shown. Without WebGL it shows the reason.
function drawMaps() {
  for (const holder of document.querySelectorAll('.map:empty')) {
    if (holder.closest('[hidden]')) continue;
    try {
      draw(holder);
    } catch (error) {
      holder.append(element('p', {class: 'undrawn'}, `The map cannot be drawn here: ${error.message}`));
    }
  }
  dispatchEvent(new Event('mapdrawn'));
}

const repaint = () => scenes.forEach((scene) => scene.paint());
addEventListener('drawmaps', drawMaps);
for (const media of ['print', '(prefers-color-scheme: dark)']) matchMedia(media).addEventListener('change', repaint);
drawMaps();
