// The 3-D replay: draws the shapes of all runs, the ground and the lights.

class Replay {
  // `live`: null, or {travels: whether the bodies will move away from their start} for a run that is still receiving frames.
  // Throws if there is no WebGL.
  constructor(stage, runs, live = null) {
    const canvas = document.createElement('canvas');
    const attributes = {antialias: true, alpha: false, preserveDrawingBuffer: true};
    const context = canvas.getContext('webgl2', attributes) || canvas.getContext('webgl', attributes);
    if (!context) throw new Error('no WebGL');
    Actor.scratch = new THREE.Vector3();
    Actor.y = new THREE.Vector3(0, 1, 0);
    this.stage = stage;
    this.live = live;
    this.renderer = new THREE.WebGLRenderer({canvas, context, antialias: true});
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    canvas.setAttribute('aria-label', '3-D replay: drag to orbit, wheel to zoom');
    stage.prepend(canvas);

    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(38, 1, 0.01, 1000);
    this.camera.up.set(0, 0, 1);
    this.ranges = {};
    this.measured = new Map();  // by run: the number of frames whose values are included in the ranges
    this.measureValues(runs);
    this.runs = runs.map((run) => this.makeRun(run));
    this.inset = {camera: new THREE.PerspectiveCamera(38, 1, 0.01, 1000), frame: stage.querySelector('#inset'), size: 0};
    this.afterRender = [];
    this.shown = 0;
    this.ghosts = false;
    this.hiddenRoles = new Set(['collision shapes']);
    this.measure();
    this.addSurroundings();
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.screenSpacePanning = true;
    this.controls.addEventListener('start', () => this.viewChosen = true);
    this.controls.addEventListener('change', () => this.requestRender());
    this.resetView();
    new ResizeObserver(() => this.resize()).observe(stage);
    this.setSize(null);
  }

  get roles() {
    return [...new Set(this.runs.flatMap((run) => run.actors.filter((a) => this.live || a.everSeen()).map((a) => a.shape.role)))];
  }

  // The colour of a role, or null if the values of its shapes colour them.
  colorOf(role) {
    const colored = this.runs.some((run) => run.actors.some((a) => a.shape.role === role && a.range));
    return colored ? null : '#' + new THREE.Color(ROLE_COLORS[role] || 0x888888).getHexString();
  }

  // Extends the range of the values of each unit over all runs, which share one colour bar.
  measureValues(runs) {
    for (const {frames} of runs) {
      const known = Math.min(this.measured.get(frames) || 0, frames.length);
      this.measured.set(frames, frames.length);
      frames.shapes.forEach((shape, i) => {
        if (!shape.unit) return;
        const range = this.ranges[shape.unit] || (this.ranges[shape.unit] = [Infinity, -Infinity]);
        for (let frame = known; frame < frames.length; ++frame) {
          const value = frames.at(i * WIDTH + VALUE, frame);
          range[0] = Math.min(range[0], value);
          range[1] = Math.max(range[1], value);
        }
      });
    }
  }

  makeRun({frames}) {
    const group = new THREE.Group();
    const cursor = new FrameCursor(frames);
    const actors = frames.shapes.map((shape, i) => new Actor(shape, i, cursor, this.ranges[shape.unit]));
    for (const actor of actors) {
      group.add(actor.object);
      if (actor.line) group.add(actor.line);
    }
    this.scene.add(group);
    return {frames, cursor, group, actors};
  }

  // Includes new frames.
  refresh() {
    this.measureValues(this.runs);
    for (const {actors} of this.runs) {
      for (const actor of actors) if (actor.line) actor.extendTrace();
    }
  }

  // Computes the bounding box of the whole run and that of the first frame. If the run leaves the latter by far, the camera
  // follows the body.
  measure() {
    this.box = new THREE.Box3();
    this.home = new THREE.Box3();
    for (const {frames, actors} of this.runs) {
      const step = Math.max(1, Math.floor(frames.time.length / 100));
      for (const actor of actors) {
        // A rope may be much longer than the robot. Its ends are in view, or far away.
        if (actor.shape.role === 'ground' || actor.shape.role === 'lines' || !actor.everSeen()) continue;
        for (let i = 0; i < frames.time.length; i += step) {
          for (const point of actor.points(i)) {
            this.box.expandByPoint(point);
            if (i === 0 && actor.shape.kind !== 'trace') this.home.expandByPoint(point);
          }
        }
      }
    }
    for (const box of [this.box, this.home]) {
      if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, 0), new THREE.Vector3(1, 1, 1));
      if (box.min.z < box.getSize(new THREE.Vector3()).length()) box.min.z = Math.min(box.min.z, 0);
    }
    this.extent = this.box.getSize(new THREE.Vector3()).length();
    const homeExtent = this.home.getSize(new THREE.Vector3()).length();
    this.travels = this.live ? this.live.travels : this.extent > 1.2 * homeExtent;
    if (this.live && this.travels) this.box.expandByVector(new THREE.Vector3(homeExtent, homeExtent, 0));
    if (this.travels) this.home.expandByScalar(0.03 * homeExtent); else this.home = this.box;
    this.direction = this.chooseDirection();

    // The radius of the bodies about their mean position.
    this.setTime(0);
    this.bodyRadius = 0;
    this.start = this.bodyPlace() || new THREE.Vector3();
    for (const actor of this.bodyParts()) {
      this.bodyRadius = Math.max(this.bodyRadius, actor.object.position.distanceTo(this.start) + actor.reach());
    }
    this.speck = this.bodyRadius < 0.05 * homeExtent;
    const arrowRadius = Math.max(0.002 * homeExtent, Math.min(0.02 * homeExtent, 0.04 * this.bodyRadius));
    for (const {actors} of this.runs) {
      for (const actor of actors) actor.arrowRadius = arrowRadius;
    }
  }

  addSurroundings() {
    const size = this.box.getSize(new THREE.Vector3());
    const center = this.box.getCenter(new THREE.Vector3());
    const cell = Math.pow(10, Math.floor(Math.log10(Math.max(size.x, size.y, 0.5)) - 0.3));
    const cells = 2 * Math.ceil(0.75 * Math.max(size.x, size.y, 4 * cell) / cell);
    const place = new THREE.Vector3(Math.round(center.x / cell) * cell, Math.round(center.y / cell) * cell, 0);
    const paint = () => {
      this.renderer.setClearColor(Theme.color('--stage'));
      this.scene.remove(this.grid);
      this.grid = new THREE.GridHelper(cells * cell, cells, Theme.color('--axis'), Theme.color('--grid'));
      this.grid.rotation.x = Math.PI / 2;
      this.grid.position.copy(place);
      this.scene.add(this.grid);
      this.requestRender();
    };
    Theme.onChange(paint);
    paint();
    const floor = new THREE.Mesh(new THREE.PlaneBufferGeometry(cells * cell, cells * cell),
                                 new THREE.ShadowMaterial({opacity: 0.16}));
    floor.position.set(place.x, place.y, -0.001);
    floor.receiveShadow = true;
    const axes = new THREE.AxesHelper(cell / 2);
    axes.position.z = 0.002;
    this.scene.add(floor, axes);

    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xb8bec8, 0.75));
    const sun = new THREE.DirectionalLight(0xffffff, 0.55);
    sun.position.copy(center).add(new THREE.Vector3(0.25, -0.35, 1).multiplyScalar(this.extent));
    sun.target.position.copy(center);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    const half = 0.6 * this.extent;
    Object.assign(sun.shadow.camera, {left: -half, right: half, top: half, bottom: -half, near: 0.01, far: 3 * this.extent});
    this.scene.add(sun, sun.target);
    this.sun = sun;
    this.surroundings = {cell, place, moved: [floor, sun, sun.target], reach: cells * cell / 4};
  }

  // Moves ground and light by whole cells when the bodies leave them.
  moveSurroundings() {
    const body = this.bodyPlace(), {cell, place, moved, reach} = this.surroundings;
    if (!body || Math.hypot(body.x - place.x, body.y - place.y) < reach) return;
    const step = new THREE.Vector3(Math.round((body.x - place.x) / cell) * cell, Math.round((body.y - place.y) / cell) * cell, 0);
    for (const {position} of [{position: place}, this.grid, ...moved]) position.add(step);
  }

  // Places the camera in a fixed direction, at the distance at which the box fits into the picture.
  resetView() {
    this.viewChosen = false;
    const moved = this.follow && this.bodyPlace() ? this.bodyPlace().sub(this.start) : new THREE.Vector3();
    this.view = this.home.clone().translate(moved);
    const center = this.view.getCenter(new THREE.Vector3());
    const {direction} = this;
    this.controls.target.copy(center);
    this.camera.position.copy(center).add(direction);
    this.camera.lookAt(center);
    this.camera.updateMatrixWorld();
    const inverse = new THREE.Matrix4().getInverse(this.camera.matrixWorld);
    const tan = Math.tan(this.camera.fov * Math.PI / 360);
    let distance = 0.1;
    for (const p of this.corners()) {
      p.applyMatrix4(inverse);
      distance = Math.max(distance, Math.abs(p.y) / tan + p.z, Math.abs(p.x) / (tan * this.camera.aspect) + p.z);
    }
    this.camera.position.copy(center).addScaledVector(direction, 1.03 * (distance + 1));
    this.center();
    this.camera.near = distance / 500;
    this.camera.far = 20 * distance + this.extent;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.requestRender();
  }

  // Moves the camera up or down such that the box is centred vertically.
  center() {
    this.camera.updateMatrixWorld();
    const inverse = new THREE.Matrix4().getInverse(this.camera.matrixWorld);
    let low = Infinity, high = -Infinity;
    for (const p of this.corners()) {
      p.applyMatrix4(inverse);
      low = Math.min(low, -p.y / p.z);
      high = Math.max(high, -p.y / p.z);
    }
    const distance = this.camera.position.distanceTo(this.controls.target);
    const up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    up.multiplyScalar((low + high) / 2 * distance);
    this.camera.position.add(up);
    this.controls.target.add(up);
  }

  corners() {
    return cornersOf(this.view);
  }

  // Draws pictures of `size`, {width, height} in pixels, at twice this resolution, so that a thin cable is a whole line. null fills
  // the stage again.
  setSize(size) {
    this.fixed = size;
    this.renderer.setPixelRatio(size ? 2 : Math.min(window.devicePixelRatio || 1, 2));
    this.resize();
  }

  resize() {
    const {width, height} = this.size = this.fixed || {width: this.stage.clientWidth, height: this.stage.clientHeight};
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, !this.fixed);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.viewChosen) this.resetView();
    this.inset.size = this.speck ? Math.round(Math.min(0.36 * width, 0.36 * height)) : 0;
    this.inset.frame.hidden = this.inset.size === 0;
    this.inset.frame.style.width = this.inset.frame.style.height = `${this.inset.size}px`;
    this.requestRender();
  }

  bodyParts() {
    const solid = ['box', 'sphere', 'cylinder', 'capsule'];
    return this.runs[this.shown].actors.filter((a) => a.shape.role === 'bodies' && solid.includes(a.shape.kind));
  }

  // The mean position of the bodies in the run that is shown.
  bodyPlace() {
    const actors = this.bodyParts();
    const sum = new THREE.Vector3();
    for (const actor of actors) sum.add(actor.object.position);
    return actors.length ? sum.divideScalar(actors.length) : null;
  }

  setFollow(follow) {
    this.follow = follow;
    this.followed = null;
    if (!follow) return;
    const place = this.bodyPlace();
    if (!place) return;
    this.followed = place;
    if (!this.speck) return;
    // Move closer, because the bodies are small compared to the scene.
    const offset = this.camera.position.clone().sub(this.controls.target);
    this.controls.target.copy(place);
    this.camera.position.copy(place).addScaledVector(offset, 0.3);
    this.viewChosen = true;
    this.controls.update();
  }

  setTime(t) {
    this.runs.forEach((run, r) => {
      const ghost = r !== this.shown;
      run.group.visible = !ghost || this.ghosts;
      if (!run.group.visible || run.frames.length === 0) return;
      run.cursor.setTime(t);
      for (const actor of run.actors) {
        actor.update();
        actor.setOpacity(ghost ? 0.25 : 1);
        const hidden = this.hiddenRoles.has(actor.shape.role) || (ghost && actor.shape.role === 'fixtures');
        if (hidden) actor.object.visible = false;
        if (actor.line) actor.line.visible = !hidden;
      }
    });
    if (this.follow && this.controls) {
      const place = this.bodyPlace();
      if (place && this.followed) {
        const step = place.clone().sub(this.followed);
        this.camera.position.add(step);
        this.controls.target.add(step);
      }
      this.followed = place;
      this.controls.update();
    }
    if (this.live && this.surroundings) this.moveSurroundings();
    this.requestRender();
  }

  // Reduces the rendering cost: first without shadows, then at a lower resolution. Returns false if no reduction is left.
  simplify() {
    if (this.coarse) return false;
    this.coarse = !this.sun.castShadow;
    this.sun.castShadow = false;
    if (this.coarse) this.renderer.setPixelRatio(0.6);
    this.requestRender();
    return true;
  }

  // The direction from the bodies to the camera: from the side on which the steepest ground is not seen edge-on.
  chooseDirection() {
    const ground = this.runs.flatMap(({frames, actors}) => frames.length ? actors.filter((a) => a.shape.role === 'ground' && a.shape.kind === 'box') : []);
    const normals = ground.map((actor) => actor.normal(0)).sort((a, b) => a.z - b.z);
    const sides = [[1, 1], [-1, 1], [1, -1], [-1, -1]].map(([x, y]) => new THREE.Vector3(0.5 * x, -0.9 * y, 0.42).normalize());
    return sides.find((side) => normals.slice(0, 1).every((normal) => normal.dot(side) > 0.3)) || sides[0];
  }

  requestRender() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => this.render());
  }

  render() {
    this.pending = false;
    const {renderer, scene, inset} = this;
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, this.size.width, this.size.height);
    renderer.render(scene, this.camera);
    for (const listener of this.afterRender) listener();
    if (!this.placeInset()) return;
    renderer.setScissorTest(true);
    renderer.setScissor(10, 10, inset.size, inset.size);
    renderer.setViewport(10, 10, inset.size, inset.size);
    renderer.render(scene, inset.camera);
  }

  // Points the camera of the close-up at bodies that are small compared to the scene. Returns whether there is a close-up.
  placeInset() {
    const {camera, size} = this.inset, place = size > 0 && this.bodyPlace();
    if (!place) return false;
    camera.up.set(0, 0, 1);
    camera.position.copy(place).addScaledVector(this.direction, 7.5 * this.bodyRadius);
    camera.lookAt(place);
    return true;
  }
}
