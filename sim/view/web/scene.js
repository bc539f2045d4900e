// The 3D scene of the view: room, robot, map and paths of a run.
import * as THREE from 'three/build/three.module.js';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {color, element} from '../../pages/web/dom.js';
import {between, kOutcomes} from './run.js';
import {withLength} from './source.js';

const kAboveGround = 0.004,
  kEllipsoids = 0.22;
const kLargest_m = 0.5; // longest half axis drawn of a landmark's ellipsoid
const kTube_m = 0.05; // between ellipsoids of the tube
const kErrorColors = ['#440154', '#21918c', '#fde725']; // none, half of the largest error, largest
const kPick_px = 12,
  kPicked_m = 0.05;
const kLowest = 1.5; // rad from the vertical: the camera stays above the floor

/// An object that is always drawn, in the color of its role.
function roled(object, role) {
  object.frustumCulled = false;
  object.userData.role = role;
  return object;
}

/// Uses the material of plain meshes, because every additional shader delays the first picture.
const lineOf = (role, Kind = THREE.Line, geometry = new THREE.BufferGeometry()) =>
  roled(new Kind(geometry, new THREE.MeshBasicMaterial()), role);

/// A line that can grow; show() sets how many of its points are drawn.
class GrowingLine {
  constructor(role, Kind) {
    this.object = lineOf(role, Kind);
    this.points = new Float32Array(3 * 1024);
    this.length = 0;
    this.attach();
  }
  attach() {
    this.object.geometry.setAttribute('position', new THREE.BufferAttribute(this.points, 3));
  }
  add(x, y, z) {
    if (3 * this.length === this.points.length) {
      const larger = new Float32Array(2 * this.points.length);
      larger.set(this.points);
      this.points = larger;
      this.attach();
    }
    this.points.set([x, y, z], 3 * this.length++);
    this.object.geometry.attributes.position.needsUpdate = true;
  }
  /// Adds the position of a pose, or repeats the last one if there is none.
  follow(pose) {
    const p = pose ?? this.last;
    this.add(...(p ? [p[0], p[1], p[2]] : [0, 0, -100]));
    this.last = p;
  }
  show(count) {
    this.object.geometry.setDrawRange(0, count);
  }
}

const pointsOf = (size) =>
  new THREE.PointsMaterial({size, sizeAttenuation: false, vertexColors: THREE.VertexColors});
const kSphere = new THREE.SphereGeometry(1, 10, 8);

function frustum(role, camera) {
  const far = 0.3,
    {width, height, fu, fv, u0, v0} = camera;
  const corners = [
    [0, 0],
    [width, 0],
    [width, height],
    [0, height]
  ].map(([u, v]) => [(far * (u - u0)) / fu, (far * (v - v0)) / fv, far]);
  const points = corners.flatMap((corner, i) => [[0, 0, 0], corner, corner, corners[(i + 1) % 4]]);
  return lineOf(
    role,
    THREE.LineSegments,
    new THREE.BufferGeometry().setFromPoints(points.map((p) => new THREE.Vector3(...p)))
  );
}

function translucent(role, opacity) {
  const material = new THREE.MeshBasicMaterial({transparent: true, opacity, depthWrite: false});
  material.userData = {role};
  return material;
}

const kBlank = new THREE.DataTexture(new Uint8Array([255, 255, 255]), 1, 1, THREE.RGBFormat);
kBlank.needsUpdate = true;

/// The material of pieces, drawn behind points and lines that lie on it. All use one shader; it is blank
/// without a picture and until the picture arrives.
const surface = () =>
  new THREE.MeshLambertMaterial({
    map: kBlank,
    vertexColors: THREE.VertexColors,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 4
  });

const glass = (opacity) => Object.assign(surface(), {transparent: true, opacity, depthWrite: false});

/// The estimated path in the color of its error, with its 3-sigma ellipsoids in their true size.
class ErrorPath {
  constructor(run, role) {
    Object.assign(this, {run, role, group: new THREE.Group()});
  }

  /// Builds it from all frames of the run, the first time that it is shown.
  build() {
    const frames = this.run.frames.filter(({estimate, truth}) => estimate && truth),
      errors = frames.map(({estimate, truth}) => between(estimate, truth)),
      [none, half, most] = kErrorColors.map((text) => new THREE.Color(text)),
      matrix = new THREE.Matrix4();
    this.largest = Math.max(...errors);
    this.times = frames.map(({t}) => t);
    const colors = errors.flatMap((error) => {
      const part = (2 * error) / this.largest;
      return (part < 1 ? none.clone().lerp(half, part) : half.clone().lerp(most, part - 1)).toArray();
    });
    const geometry = new THREE.BufferGeometry(),
      set = (name, values) => geometry.setAttribute(name, new THREE.Float32BufferAttribute(values, 3));
    set(
      'position',
      frames.flatMap(({estimate}) => estimate.slice(0, 3))
    );
    set('color', colors);
    this.points = new THREE.Points(geometry, pointsOf(7));
    const far = ({estimate}, last) => !last || between(estimate, last.estimate) > kTube_m;
    this.rings = [];
    for (const frame of frames) if (frame.ellipsoid && far(frame, this.rings.at(-1))) this.rings.push(frame);
    this.tube = new THREE.InstancedMesh(kSphere, translucent(this.role, kEllipsoids), this.rings.length || 1);
    this.tube.material.color.set(color(this.role));
    this.rings.forEach(({estimate, ellipsoid}, k) => {
      setEllipsoid(matrix, estimate, ellipsoid);
      this.tube.setMatrixAt(k, matrix);
    });
    this.points.frustumCulled = this.tube.frustumCulled = false;
    this.group.add(this.points, this.tube);
  }

  show(t) {
    if (!this.group.visible) return;
    if (!this.points) this.build();
    this.points.geometry.setDrawRange(0, this.times.filter((at) => at <= t).length);
    this.tube.count = this.rings.filter((frame) => frame.t <= t).length;
  }
}

/// A filter's estimate: its path, its camera with the 3-sigma ellipsoid enlarged ten times, a line to the
/// truth, and its map.
class Belief {
  constructor(run, role, mapRole, showsTruth) {
    Object.assign(this, {run, mapRole, read: 0});
    this.path = new GrowingLine(role);
    this.truth = showsTruth ? new GrowingLine(role) : null; // if it is from another walk
    this.frustum = frustum(role, run.camera);
    this.error = lineOf(role);
    this.own = new THREE.Mesh(kSphere, translucent(role, 0.5));
    this.own.matrixAutoUpdate = false;
    this.points = new THREE.Points(new THREE.BufferGeometry(), pointsOf(5));
    this.errors = new ErrorPath(run, role);
    this.map = new THREE.Group();
    this.landmarks = [];
    this.map.add(this.points);
    this.reserve(1024);
    this.near = [this.frustum, this.error, this.own];
    this.objects = [this.path.object, ...this.near, ...(this.truth ? [this.truth.object] : [])];
    this.own.frustumCulled = this.points.frustumCulled = false;
    if (this.truth) Object.assign(this.truth.object.material, {transparent: true, opacity: 0.5});
    this.group = new THREE.Group();
    this.group.add(...this.objects, this.map, this.errors.group);
  }

  /// Reserves space for that many landmarks.
  reserve(count) {
    if (count <= this.ellipsoids?.instanceMatrix.count) return;
    const capacity = 2 ** Math.ceil(Math.log2(count));
    this.map.remove(this.ellipsoids);
    this.ellipsoids = new THREE.InstancedMesh(kSphere, translucent(this.mapRole, kEllipsoids), capacity);
    this.ellipsoids.material.color.set(color(this.mapRole));
    this.ellipsoids.frustumCulled = false;
    this.map.add(this.ellipsoids);
    for (const name of ['position', 'color'])
      this.points.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * capacity), 3));
  }

  show(index) {
    for (; this.read < this.run.frames.length; ++this.read) {
      const frame = this.run.frames[this.read];
      this.path.follow(frame.estimate);
      this.truth?.follow(frame.truth);
    }
    this.frame = this.run.frames[index] ?? {};
    const {estimate, truth, ellipsoid, searches} = this.frame;
    this.path.show(index + 1);
    this.truth?.show(index + 1);
    this.frustum.visible = Boolean(estimate);
    if (estimate) place(this.frustum, estimate);
    this.error.visible = Boolean(estimate && truth);
    if (this.error.visible)
      this.error.geometry.setFromPoints([estimate, truth].map(([x, y, z]) => new THREE.Vector3(x, y, z)));
    this.own.visible = Boolean(estimate && ellipsoid);
    if (this.own.visible)
      setEllipsoid(
        this.own.matrix,
        estimate,
        ellipsoid.map((x) => 10 * x)
      );
    this.showMap(this.run.mapAt(index), searches ?? []);
  }

  showMap(map, searches) {
    const outcomes = new Map(searches.map((search) => [search[0], search[6]])),
      matrix = new THREE.Matrix4(),
      paint = new THREE.Color(),
      own = color(this.mapRole);
    this.landmarks = map;
    this.reserve(map.length);
    const {position, color: colors} = this.points.geometry.attributes;
    map.forEach(([id, p, axes], k) => {
      setEllipsoid(matrix, p, capped(axes));
      this.ellipsoids.setMatrixAt(k, matrix);
      paint.set(kOutcomes[outcomes.get(id)] ?? own);
      position.setXYZ(k, ...p);
      colors.setXYZ(k, paint.r, paint.g, paint.b);
    });
    this.ellipsoids.count = map.length;
    this.ellipsoids.instanceMatrix.needsUpdate = position.needsUpdate = colors.needsUpdate = true;
    this.points.geometry.setDrawRange(0, map.length);
  }
}

/// The half axes are the columns.
function capped(axes) {
  const factors = [0, 1, 2].map((k) =>
    Math.min(1, kLargest_m / Math.hypot(axes[k], axes[k + 3], axes[k + 6]) || 1)
  );
  return axes.map((value, i) => value * factors[i % 3]);
}

function setEllipsoid(matrix, p, [a, b, c, d, e, f, g, h, i]) {
  matrix.set(a, b, c, p[0], d, e, f, p[1], g, h, i, p[2], 0, 0, 0, 1);
}

function place(object, [x, y, z, ...quaternion]) {
  object.position.set(x, y, z);
  object.quaternion.set(...quaternion).normalize();
}

export class Scene {
  /// run: its robot and true path are shown; others: {run, role} of the runs that are compared with it.
  constructor(run, others) {
    Object.assign(this, {
      run,
      mode: 'follow',
      read: 0,
      bodies: [],
      surfaces: [],
      plain: surface(),
      sweeps: new Map(),
      hidden: new Set()
    });
    this.beliefs = [
      new Belief(run, 'estimate', others.length ? 'estimate' : 'first', false),
      ...others.map(
        (other) =>
          new Belief(other.run, other.role, other.role, other.run.about.recording !== run.about.recording)
      )
    ];
    this.scene = new THREE.Scene();
    this.element = element('div', {
      class: 'scene',
      tabindex: 0,
      role: 'application',
      'aria-label': 'room, robot and map in 3D; arrow keys rotate the view, plus and minus zoom'
    });
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.05, 60);
    this.head = new THREE.PerspectiveCamera(73.7, 4 / 3, 0.05, 60);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-2.1, -2.5, 2.2);
    this.controls = new OrbitControls(this.camera, this.element);
    this.controls.enableKeys = false;
    this.controls.maxPolarAngle = kLowest;
    this.controls.target.set(0, 0, 0.7);
    this.controls.addEventListener('change', () => {
      this.controls.target.z = Math.max(0, this.controls.target.z); // panning must not lead below the floor
      this.camera.position.z = Math.max(0.05, this.camera.position.z);
      this.draw();
    });
    this.element.addEventListener('keydown', (event) => this.steer(event));
    this.fill();
    try {
      this.open();
    } catch (error) {
      this.element.append(
        element('p', {class: 'note'}, `The 3D scene cannot be drawn here: ${error.message}`)
      );
    }
  }

  /// Throws without WebGL; then nothing is drawn.
  open() {
    this.renderer = new THREE.WebGLRenderer({antialias: true});
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.debug.checkShaderErrors = false; // the check would wait for each shader
    this.element.prepend(this.renderer.domElement);
    this.renderer.domElement.addEventListener('webglcontextlost', () => this.element.classList.add('lost'));
    this.renderer.domElement.addEventListener('webglcontextrestored', () => {
      this.element.classList.remove('lost');
      this.draw();
    });
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  fill() {
    this.scene.add(new THREE.AmbientLight(0xffffff, 0.7));
    this.add(new THREE.DirectionalLight(0xffffff, 0.45)).position.set(-2, -3, 6);
    const {
      camera,
      about: {has_model: hasRoom}
    } = this.run;
    if (!hasRoom) {
      const floor = this.add(new THREE.GridHelper(12, 12));
      floor.rotation.x = Math.PI / 2;
      Object.assign(floor.material, {transparent: true, opacity: 0.35});
    }
    this.paths = {truth: new GrowingLine('truth'), plan: new GrowingLine('plan')};
    this.frustum = frustum('truth', camera);
    this.landed = new GrowingLine('landed', THREE.LineSegments);
    this.planned = new GrowingLine('plan', THREE.LineSegments);
    this.walk = new THREE.Group(); // the walk of the first run and of other runs on the same recording
    this.walk.add(
      ...[...Object.values(this.paths), this.landed, this.planned].map(({object}) => object),
      this.frustum
    );
    this.scene.add(this.walk, ...this.beliefs.map(({group}) => group));
    this.support = lineOf('first', THREE.LineLoop);
    this.walk.add(this.support);
    this.zmp = this.add(
      new THREE.Mesh(new THREE.SphereGeometry(0.012, 12, 8), new THREE.MeshBasicMaterial()),
      'bad',
      this.walk
    );
    this.mark = this.add(new THREE.Mesh(kSphere, translucent('plan', 0.6)));
    this.mark.scale.setScalar(kPicked_m);
    this.mark.visible = false;
    this.layers = {
      truth: [this.paths.truth.object, this.frustum],
      plan: [this.paths.plan.object, this.planned.object],
      steps: [this.landed.object, this.support, this.zmp]
    };
    this.beliefs.forEach(({objects, map, errors}, i) =>
      Object.assign(this.layers, {
        [`estimate${i}`]: objects,
        [`map${i}`]: [map],
        [`errors${i}`]: [errors.group]
      })
    );
    for (const name of this.optional) this.hidden.add(name);
    this.paint();
  }

  add(object, role = null, group = this.scene) {
    group.add(roled(object, role));
    return object;
  }

  /// buffer: pieces in the format of Model in sim/view/site.h.
  addModel(buffer) {
    const [pieces, begin] = withLength(buffer);
    let at = begin;
    const take = (Kind, count, size) => {
      const values = new Kind(buffer, at, count * size);
      at += values.byteLength;
      return new THREE.BufferAttribute(values, size);
    };
    this.bodies = Array.from(
      {length: Math.max(-1, ...pieces.map(({body}) => body)) + 1},
      () => new THREE.Group()
    );
    this.bodies.forEach((body) => {
      body.visible = false;
      this.scene.add(body);
    });
    for (const {body, picture, alpha, vertices, indices} of pieces) {
      const geometry = new THREE.BufferGeometry(),
        opaque = () => (picture < 0 ? this.plain : (this.surfaces[picture] ??= surface())),
        material = alpha < 1 ? glass(alpha) : opaque();
      for (const name of ['position', 'normal', 'color'])
        geometry.setAttribute(name, take(Float32Array, vertices, 3));
      if (picture >= 0) geometry.setAttribute('uv', take(Float32Array, vertices, 2));
      geometry.setIndex(take(Uint32Array, indices, 1));
      (this.bodies[body] ?? this.scene).add(new THREE.Mesh(geometry, material));
    }
    this.resize();
  }

  get isWaiting() {
    return !this.renderer || (this.run.about.has_model && !this.bodies.length);
  }

  addPicture(number, image) {
    const texture = new THREE.Texture(image);
    texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
    Object.assign(texture, {format: THREE.RGBFormat, flipY: false, needsUpdate: true});
    this.surfaces[number].map = texture;
  }

  paint() {
    this.scene.background = new THREE.Color(color('panel'));
    this.scene.traverse((object) => {
      const role = object.userData.role ?? object.material?.userData?.role;
      if (role) object.material.color.set(color(role));
    });
    this.draw();
  }

  readFrames() {
    for (; this.read < this.run.frames.length; ++this.read) {
      const frame = this.run.frames[this.read];
      for (const [name, path] of Object.entries(this.paths)) path.follow(frame[name]);
    }
    for (const name of ['landed', 'planned']) {
      const lines = this[name]; // eight points per step
      for (const {corners} of this.run[name].slice(lines.length / 8)) {
        for (const corner of corners.flatMap((from, i) => [from, corners[(i + 1) % 4]]))
          lines.add(...corner, kAboveGround);
      }
    }
  }

  show(index) {
    this.readFrames();
    const frame = this.run.frames[index];
    if (!frame) return;
    for (const path of Object.values(this.paths)) path.show(index + 1);
    for (const name of ['landed', 'planned'])
      this[name].show(8 * this.run[name].filter(({t}) => t <= frame.t).length);
    this.poseRobot(frame);
    for (const layer of Object.values(this.layers)) for (const object of layer) object.visible = true;
    this.frustum.visible = Boolean(frame.truth) && this.mode !== 'head';
    if (frame.truth) place(this.frustum, frame.truth);
    for (const belief of this.beliefs)
      belief.show(belief.run === this.run ? index : belief.run.indexAt(frame.t));
    if (this.mode === 'head')
      for (const {near} of this.beliefs) for (const object of near) object.visible = false;
    this.showZmp(frame);
    for (const name of this.hidden) for (const object of this.layers[name] ?? []) object.visible = false;
    for (const {errors} of this.beliefs) errors.show(frame.t);
    this.moveView(frame);
    this.draw();
  }

  /// The names of the layers that are shown only on request.
  get optional() {
    return this.beliefs.map((_, i) => `errors${i}`);
  }

  poseRobot({bodies}) {
    this.bodies.forEach((body, i) => {
      body.visible = Boolean(bodies);
      if (bodies) place(body, bodies.slice(7 * i, 7 * i + 7));
    });
  }

  /// The run and the landmark drawn at a position on the page; null: none.
  pick({clientX, clientY}) {
    const {left, top, width: whole, height} = this.element.getBoundingClientRect(),
      at = new THREE.Vector3(),
      width = whole / this.columns;
    let best = null,
      nearest = kPick_px;
    this.beliefs.forEach(({landmarks}, run) =>
      landmarks.forEach(([id, p]) => {
        at.set(...p).project(this.mode === 'head' ? this.head : this.camera);
        const begin = left + (this.isSplit ? run * width : 0),
          px = ((at.x + 1) / 2) * width;
        const far =
          px < 0 || px > width
            ? Infinity
            : Math.hypot(begin + px - clientX, top + ((1 - at.y) / 2) * height - clientY);
        if (!this.hidden.has(`map${run}`) && at.z < 1 && far < nearest) [best, nearest] = [{run, id}, far];
      })
    );
    return best;
  }

  /// Highlights a landmark of a run; null: none.
  showPicked(picked) {
    const found = picked && this.beliefs[picked.run].landmarks.find(([id]) => id === picked.id);
    this.mark.visible = Boolean(found);
    if (found) this.mark.position.set(...found[1]);
    this.draw();
  }

  showZmp(frame) {
    this.zmp.visible = Boolean(frame.zmp);
    if (frame.zmp) this.zmp.position.set(frame.zmp[0], frame.zmp[1], kAboveGround);
    this.support.visible = Boolean(frame.support);
    if (frame.support)
      this.support.geometry.setFromPoints(
        frame.support.map(([x, y]) => new THREE.Vector3(x, y, 2 * kAboveGround))
      );
  }

  /// Shows lidar points in the axes of the camera: x, y, z (m) and intensity, one after another; null: none.
  /// colorOf(height in m, intensity): red, green and blue from 0 to 1.
  showSweep(name, points, colorOf) {
    let sweep = this.sweeps.get(name);
    if (!sweep) {
      sweep = this.add(new THREE.Points(new THREE.BufferGeometry(), pointsOf(3)), null, this.walk);
      this.sweeps.set(name, sweep);
    }
    sweep.visible = Boolean(points);
    if (this.pose) place(sweep, this.pose);
    if (points) {
      sweep.updateMatrix();
      const {elements: m} = sweep.matrix,
        values = new THREE.InterleavedBuffer(points, 4),
        colors = new Float32Array(3 * values.count);
      for (let i = 0; i < values.count; ++i)
        colors.set(
          colorOf(
            m[2] * points[4 * i] + m[6] * points[4 * i + 1] + m[10] * points[4 * i + 2] + m[14],
            points[4 * i + 3]
          ),
          3 * i
        );
      sweep.geometry.setAttribute('position', new THREE.InterleavedBufferAttribute(values, 3, 0));
      sweep.geometry.setAttribute('color', new THREE.BufferAttribute(colors, 3));
    }
    this.draw();
  }

  moveView(frame) {
    const pose = frame.truth ?? frame.estimate;
    if (!pose) return;
    this.pose = pose;
    for (const sweep of this.sweeps.values()) place(sweep, pose);
    if (this.mode === 'follow') {
      const target = new THREE.Vector3(pose[0], pose[1], 0.7),
        moved = target.clone().sub(this.controls.target);
      this.camera.position.add(moved);
      this.controls.target.copy(target);
      this.camera.lookAt(target);
    }
    this.lookThrough(pose);
  }

  lookThrough(pose) {
    place(this.head, pose);
    this.head.quaternion.multiply(new THREE.Quaternion(1, 0, 0, 0)); // three.js looks along -z with y up
  }

  /// mode: 'follow' the robot, 'orbit' around the path, or look through the 'head' camera.
  setMode(mode, index) {
    this.mode = mode;
    this.resize();
    this.show(index);
  }

  /// Shows one view per run, side by side with the same camera, or a single one of all runs.
  setSplit(isSplit) {
    this.isSplit = isSplit && this.beliefs.length > 1;
    this.element.classList.toggle('split', this.isSplit);
    this.resize();
  }

  get columns() {
    return this.isSplit ? this.beliefs.length : 1;
  }

  /// Arrow keys rotate the view about its target; + and - zoom.
  steer(event) {
    const turn = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]}[
      event.key
    ];
    const zoom = {'+': 0.9, '=': 0.9, '-': 1.1}[event.key];
    if (!turn && !zoom) return;
    event.preventDefault();
    event.stopPropagation();
    const {camera, controls} = this,
      spherical = new THREE.Spherical(),
      offset = camera.position.clone().sub(controls.target);
    spherical.setFromCartesianCoords(offset.y, offset.z, offset.x);
    spherical.theta += turn?.[0] ?? 0;
    spherical.phi = Math.min(kLowest, Math.max(0.05, spherical.phi + (turn?.[1] ?? 0)));
    spherical.radius *= zoom ?? 1;
    offset.setFromSpherical(spherical);
    camera.position.copy(controls.target).add(new THREE.Vector3(offset.z, offset.x, offset.y));
    controls.update();
    this.draw();
  }

  resize() {
    const width = this.element.clientWidth,
      height = this.element.clientHeight;
    // The first resize waits for the graphics card, which gets ready while the model is loaded.
    if (!width || !height || this.isWaiting) return;
    this.renderer.setSize(width, height);
    // All shaders at once; a resize would otherwise wait for them.
    if (!this.isCompiled) this.renderer.compile(this.scene, this.camera);
    this.isCompiled = true;
    const {camera} = this.run,
      column = width / this.columns,
      aspect = column / height,
      half = Math.max(camera.height / 2 / camera.fv, camera.width / 2 / camera.fu / aspect);
    this.camera.aspect = aspect;
    this.head.fov = (2 * Math.atan(half) * 180) / Math.PI;
    // Page pixels per image pixel; the optical axis is off the image center.
    const scale = height / 2 / half / camera.fv;
    this.head.setViewOffset(
      column,
      height,
      scale * ((camera.width - 1) / 2 - camera.u0),
      scale * ((camera.height - 1) / 2 - camera.v0),
      column,
      height
    );
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /// Draws once before the browser next repaints the page, no matter how often it is called until then.
  draw() {
    this.drawing ??= requestAnimationFrame(() => this.render());
  }

  render() {
    this.drawing = null;
    if (this.isWaiting) return;
    const {columns, renderer} = this,
      {x, y: height} = renderer.getSize(new THREE.Vector2()),
      width = x / columns;
    renderer.setScissorTest(columns > 1);
    for (let column = 0; column < columns; ++column) {
      this.walk.visible = columns === 1 || !this.beliefs[column].truth;
      this.beliefs.forEach(({group, frame}, run) => {
        group.visible = columns === 1 || run === column;
        if (columns === 1 || run !== column || !frame) return;
        this.poseRobot(frame);
        if (frame.truth ?? frame.estimate) this.lookThrough(frame.truth ?? frame.estimate);
      });
      renderer.setViewport(column * width, 0, width, height);
      renderer.setScissor(column * width, 0, width, height);
      renderer.render(this.scene, this.mode === 'head' ? this.head : this.camera);
    }
  }
}
