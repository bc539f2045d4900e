// The map in three dimensions: landmarks with their 3-sigma ellipsoids, the three paths, and the camera at a time.
import * as THREE from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {color, countDrawn, countExpected, element} from './dom.js';

function pathLine(path, role) {
  const points = path.x.map((x, i) => new THREE.Vector3(x, path.y[i], path.z[i]));
  const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial());
  line.userData.role = role;
  return line;
}

/// axes: the three columns of an ellipsoid's half axes (m), row by row.
function ellipsoid(center, axes, role) {
  const mesh = new THREE.Mesh(new THREE.SphereGeometry(1, 12, 8),
    new THREE.MeshBasicMaterial({transparent: true, opacity: 0.16, depthWrite: false}));
  mesh.matrixAutoUpdate = false;
  const [a, b, c, d, e, f, g, h, i] = axes;
  mesh.matrix.set(a, b, c, center[0], d, e, f, center[1], g, h, i, center[2], 0, 0, 0, 1);
  mesh.userData.role = role;
  return mesh;
}

function landmarkPoints(landmarks) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(landmarks.flatMap((l) => l.p), 3));
  const points = new THREE.Points(geometry, new THREE.PointsMaterial({size: 5, sizeAttenuation: false}));
  points.userData.role = 'first';
  return points;
}

/// A pyramid of 90 degrees that looks along z of the camera.
function frustum() {
  const s = 0.25, corners = [[-s, -0.75 * s, s], [s, -0.75 * s, s], [s, 0.75 * s, s], [-s, 0.75 * s, s]];
  const lines = corners.flatMap((corner, i) => [[0, 0, 0], corner, corner, corners[(i + 1) % 4]]);
  const geometry = new THREE.BufferGeometry().setFromPoints(lines.map((p) => new THREE.Vector3(...p)));
  const object = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial());
  object.userData.role = 'estimate';
  return object;
}

function paint(scene) {
  scene.background = new THREE.Color(color('panel'));
  scene.traverse((object) => {
    if (object.userData.role) object.material.color.set(color(object.userData.role));
  });
}

function grid(scene3d) {
  const lines = new THREE.GridHelper(12, 12);
  lines.rotation.x = Math.PI / 2;
  lines.material.transparent = true;
  lines.material.opacity = 0.35;
  scene3d.add(lines);
}

class View {
  constructor(data, holder) {
    this.data = data;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.05, 100);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-3.5, -5, 5.5);
    this.renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
    holder.append(this.renderer.domElement);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.target.set(0.8, 0, 0.8);
    this.controls.addEventListener('change', () => this.draw());
    this.fill();
    new ResizeObserver(() => this.resize(holder)).observe(holder);
    this.resize(holder);
  }

  fill() {
    const {data, scene} = this;
    grid(scene);
    for (const role of ['plan', 'truth', 'estimate']) scene.add(pathLine(data[role], role));
    this.landmarks = landmarkPoints(data.landmarks);
    this.ellipsoids = new THREE.Group();
    for (const l of data.landmarks) this.ellipsoids.add(ellipsoid(l.p, l.axes, 'first'));
    this.frustum = frustum();
    this.camera_ellipsoid = ellipsoid([0, 0, 0], [1, 0, 0, 0, 1, 0, 0, 0, 1], 'estimate');
    this.camera_ellipsoid.material.opacity = 0.5;
    scene.add(this.landmarks, this.ellipsoids, this.frustum, this.camera_ellipsoid);
    paint(scene);
    this.show(data.poses.length - 1);
  }

  show(index) {
    const pose = this.data.poses[index];
    this.frustum.position.set(...pose.p);
    this.frustum.quaternion.set(...pose.q);
    const scaled = pose.axes.map((value) => 10 * value);
    const [a, b, c, d, e, f, g, h, i] = scaled;
    this.camera_ellipsoid.matrix.set(a, b, c, pose.p[0], d, e, f, pose.p[1], g, h, i, pose.p[2], 0, 0, 0, 1);
    this.data.landmarks.forEach((l, k) => { this.ellipsoids.children[k].visible = l.begun <= pose.t; });
    const count = this.data.landmarks.filter((l) => l.begun <= pose.t).length;
    this.landmarks.geometry.setDrawRange(0, count);
    this.draw();
  }

  resize(holder) {
    const width = holder.clientWidth, height = holder.clientHeight;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() { this.renderer.render(this.scene, this.camera); }
  repaint() { paint(this.scene); this.draw(); }
}

const views = [];
export const repaintScenes = () => views.forEach((view) => view.repaint());

function controls(data, view) {
  const label = element('output', {}, '');
  const say = (i) => { label.textContent = `${data.poses[i].t.toFixed(1)} s`; };
  const slider = element('input', {type: 'range', min: 0, max: data.poses.length - 1, value: data.poses.length - 1,
    'aria-label': 'time', oninput: () => { say(+slider.value); view.show(+slider.value); }});
  const ellipsoids = element('input', {type: 'checkbox', checked: '',
    onchange: () => { view.ellipsoids.visible = ellipsoids.checked; view.draw(); }});
  say(data.poses.length - 1);
  return element('div', {class: 'controls'}, 'time', slider, label, element('label', {}, ellipsoids, ' landmark ellipsoids'));
}

/// The map's element. Without WebGL it says so.
export function sceneElement(data) {
  const holder = element('div', {class: 'scene', 'data-figure': 'map_3d'});
  const shown = element('figure', {}, element('figcaption', {},
    'Map: landmarks with 3-sigma ellipsoids; camera with its 3-sigma ellipsoid ten times as large. Drag to turn, wheel to zoom.'), holder);
  countExpected();
  setTimeout(() => {
    try {
      const view = new View(data, holder);
      views.push(view);
      shown.append(controls(data, view));
      countDrawn();
    } catch (error) {
      holder.style.height = 'auto';
      holder.append(`The map cannot be drawn here: ${error.message}`);
    }
  });
  return shown;
}
