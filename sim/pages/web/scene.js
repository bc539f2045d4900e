// The map in three dimensions: landmarks with their 3-sigma ellipsoids, the three paths, and the camera at a time.
import * as THREE from 'three/build/three.module.js';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {color, countDrawn, countExpected, element} from './dom.js';

function pathLine(path, role) {
  const points = path.x.map((x, i) => new THREE.Vector3(x, path.y[i], path.z[i]));
  const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial());
  line.userData.role = role;
  return line;
}

function ellipsoid(role) {
  const mesh = new THREE.Mesh(new THREE.SphereGeometry(1, 12, 8),
    new THREE.MeshBasicMaterial({transparent: true, opacity: 0.16, depthWrite: false}));
  mesh.matrixAutoUpdate = false;
  mesh.frustumCulled = false;
  mesh.userData.role = role;
  return mesh;
}

/// As many points and ellipsoids as the largest map has; show() moves those of a time to their places.
function landmarkPoints(count) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(new Float32Array(3 * count), 3));
  const points = new THREE.Points(geometry, new THREE.PointsMaterial({size: 5, sizeAttenuation: false}));
  points.frustumCulled = false;
  points.userData.role = 'first';
  return points;
}

function place(mesh, p, [a, b, c, d, e, f, g, h, i]) {
  mesh.matrix.set(a, b, c, p[0], d, e, f, p[1], g, h, i, p[2], 0, 0, 0, 1);
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
    holder.addEventListener('keydown', (event) => this.steer(event));
    this.fill();
    new ResizeObserver(() => this.resize(holder)).observe(holder);
    this.resize(holder);
  }

  fill() {
    const {data, scene} = this;
    grid(scene);
    for (const role of ['plan', 'truth', 'estimate']) scene.add(pathLine(data[role], role));
    const most = Math.max(...data.maps.map((map) => map.landmarks.length));
    this.landmarks = landmarkPoints(most);
    this.ellipsoids = new THREE.Group();
    for (let k = 0; k < most; ++k) this.ellipsoids.add(ellipsoid('first'));
    this.frustum = frustum();
    this.camera_ellipsoid = ellipsoid('estimate');
    this.camera_ellipsoid.material.opacity = 0.5;
    scene.add(this.landmarks, this.ellipsoids, this.frustum, this.camera_ellipsoid);
    paint(scene);
    this.show(data.poses.length - 1);
  }

  show(index) {
    const pose = this.data.poses[index];
    this.frustum.position.set(...pose.p);
    this.frustum.quaternion.set(...pose.q);
    place(this.camera_ellipsoid, pose.p, pose.axes.map((value) => 10 * value));
    this.showMap(this.data.maps.findLast((map) => map.t <= pose.t + 1e-6) ?? this.data.maps[0]);
    this.draw();
  }

  showMap({landmarks}) {
    const {position} = this.landmarks.geometry.attributes;
    this.ellipsoids.children.forEach((mesh, k) => { mesh.visible = k < landmarks.length; });
    landmarks.forEach(({p, axes}, k) => {
      position.setXYZ(k, ...p);
      place(this.ellipsoids.children[k], p, axes);
    });
    position.needsUpdate = true;
    this.landmarks.geometry.setDrawRange(0, landmarks.length);
  }

  /// Arrows turn the view about its target, + and - come nearer and go away.
  steer(event) {
    const turn = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]}[event.key];
    const zoom = {'+': 0.9, '=': 0.9, '-': 1.1}[event.key];
    if (!turn && !zoom) return;
    event.preventDefault();
    const {camera, controls} = this, offset = camera.position.clone().sub(controls.target);
    let azimuth = Math.atan2(offset.y, offset.x), polar = Math.acos(offset.z / offset.length());
    azimuth += turn?.[0] ?? 0;
    polar = Math.min(3.1, Math.max(0.05, polar + (turn?.[1] ?? 0)));
    const far = offset.length() * (zoom ?? 1), flat = far * Math.sin(polar);
    camera.position.copy(controls.target)
      .add(new THREE.Vector3(flat * Math.cos(azimuth), flat * Math.sin(azimuth), far * Math.cos(polar)));
    controls.update();
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
  const holder = element('div', {class: 'scene', 'data-figure': 'map_3d', tabindex: 0, role: 'application',
    'aria-label': 'map in three dimensions; arrow keys turn it, plus and minus zoom'});
  const shown = element('figure', {}, element('figcaption', {},
    'Map: landmarks with 3-sigma ellipsoids; camera with its 3-sigma ellipsoid ten times as large. Drag or arrow keys to turn, wheel or + and - to zoom.'), holder);
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
