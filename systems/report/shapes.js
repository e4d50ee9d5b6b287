// The shapes of a run at a given time, as objects of three.js, independent of the robot to which they belong.

const ROLE_COLORS = {
  bodies: 0x3d5a80, lines: 0x777777, loads: 0xb5651d, others: 0x7a6c5d, ground: 0xc9c2b4, fixtures: 0x9aa3af,
  forces: 0x2a9d5c, disturbances: 0xd62828, estimates: 0xf08c00, reference: 0x1aa6a6, 'collision shapes': 0x8e44ad,
};
// Columns of a shape in a frame, in the order of Shape::Fields().
const WIDTH = 12, P = 0, Q = 3, VECTOR = 7, VALUE = 10, VISIBLE = 11;

// Interpolates the frames of a run at a given time.
class FrameCursor {
  constructor(frames) {
    this.frames = frames;
  }
  get time() {
    return this.frames.time;
  }
  setTime(t) {
    const time = this.time;
    this.a = indexAt(time, t);
    this.b = Math.min(this.a + 1, time.length - 1);
    const span = time[this.b] - time[this.a];
    this.fraction = span > 0 ? Math.min(Math.max((t - time[this.a]) / span, 0), 1) : 0;
  }
  at(column, frame) {
    return this.frames.at(column, frame);
  }
  value(column) {
    const a = this.at(column, this.a);
    return a + this.fraction * (this.at(column, this.b) - a);
  }
  vector(column, out) {
    return out.set(this.value(column), this.value(column + 1), this.value(column + 2));
  }
  // Interpolates along the shorter rotation; q and -q are the same attitude.
  quaternion(column, out) {
    const q = (frame) => [1, 2, 3, 0].map((k) => this.at(column + k, frame));
    out.set(...q(this.a));
    return this.fraction > 0 ? out.slerp(new THREE.Quaternion(...q(this.b)), this.fraction) : out;
  }
}

function cornersOf({min, max}) {
  return [min.x, max.x].flatMap((x) => [min.y, max.y].flatMap((y) => [min.z, max.z].map((z) => new THREE.Vector3(x, y, z))));
}

// One shape as objects of three.js.
class Actor {
  constructor(shape, index, frames, unitRange) {
    this.shape = shape;
    this.base = index * WIDTH;
    this.frames = frames;
    this.range = shape.unit ? unitRange : null;
    const color = ROLE_COLORS[shape.role] || 0x888888;
    this.material = new THREE.MeshPhongMaterial({color, shininess: 25, specular: 0x222222});
    this.object = new THREE.Group();
    const add = (geometry) => {
      const mesh = new THREE.Mesh(geometry, this.material);
      mesh.castShadow = shape.role !== 'ground';
      mesh.receiveShadow = shape.role === 'ground';
      this.object.add(mesh);
      return mesh;
    };
    const [x, y, z] = shape.size;
    switch (shape.kind) {
      case 'box': {
        add(new THREE.BoxBufferGeometry(x, y, z));
        const edges = new THREE.EdgesGeometry(new THREE.BoxBufferGeometry(x, y, z));
        this.edges = new THREE.LineBasicMaterial({color: new THREE.Color(color).multiplyScalar(0.55)});
        this.object.add(new THREE.LineSegments(edges, this.edges));
        break;
      }
      case 'sphere': add(new THREE.SphereBufferGeometry(x, 24, 16)); break;
      case 'capsule':
        for (const end of [-1, 1]) add(new THREE.SphereBufferGeometry(x, 20, 14)).position.z = end * y / 2;
        // falls through
      case 'cylinder': add(new THREE.CylinderBufferGeometry(x, x, y, 24)).rotation.x = Math.PI / 2; break;
      case 'mesh': this.makeMesh(shape, add); break;
      case 'segment': add(new THREE.CylinderBufferGeometry(1, 1, 1, 10)); break;
      case 'arrow':
        this.head = add(new THREE.ConeBufferGeometry(1, 1, 16));
        this.shaft = add(new THREE.CylinderBufferGeometry(1, 1, 1, 12));
        // The part behind bodies, or inside, shines through them.
        this.hidden = new THREE.MeshBasicMaterial({color, transparent: true, depthFunc: THREE.GreaterDepth, depthWrite: false});
        for (const part of [this.head, this.shaft]) part.add(new THREE.Mesh(part.geometry, this.hidden));
        break;
      case 'trace': this.makeTrace(x, color, add); break;
      default: throw new Error(`no shape is called '${shape.kind}'`);
    }
  }

  makeMesh(shape, add) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(decode(shape.corners, Float32Array), 3));
    geometry.setIndex(new THREE.BufferAttribute(decode(shape.triangles, Uint32Array), 1));
    geometry.computeVertexNormals();
    geometry.computeBoundingSphere();
    if (shape.colours) {
      const rgba = decode(shape.colours, Uint8Array), own = this.material.color.toArray();
      const rgb = Float32Array.from({length: rgba.length / 4 * 3}, (_, i) => {
        const corner = 4 * Math.floor(i / 3), k = i % 3;
        return rgba[corner + 3] ? rgba[corner + k] / 255 : own[k];
      });
      geometry.setAttribute('color', new THREE.BufferAttribute(rgb, 3));
      this.material.vertexColors = THREE.VertexColors;
      this.material.color.set(0xffffff);
    }
    this.material.flatShading = true;
    this.material.side = THREE.DoubleSide;  // many files have triangles of inconsistent orientation
    add(geometry);
    this.meshReach = geometry.boundingSphere.center.length() + geometry.boundingSphere.radius;
    geometry.computeBoundingBox();
    this.meshBox = geometry.boundingBox;
  }

  makeTrace(radius, color, add) {
    this.edges = this.shape.role === 'reference' ?
        new THREE.LineDashedMaterial({color, dashSize: 0.06, gapSize: 0.04}) :
        new THREE.LineBasicMaterial({color});
    this.line = new THREE.Line(new THREE.BufferGeometry(), this.edges);
    this.line.frustumCulled = false;
    this.extendTrace();
    if (radius > 0) this.ball = add(new THREE.SphereBufferGeometry(radius, 20, 14));
  }

  // Extends the trace by the new frames, or rebuilds it if old frames were removed.
  extendTrace() {
    const {frames} = this.frames, n = frames.length, {geometry} = this.line;
    if (this.cuts !== frames.cuts) this.traced = 0;
    this.cuts = frames.cuts;
    if (!geometry.attributes.position || n > geometry.attributes.position.count) {
      const room = this.traced ? 2 * n : n;
      geometry.dispose();
      geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * room), 3));
      geometry.setAttribute('lineDistance', new THREE.BufferAttribute(new Float32Array(room), 1));
      this.traced = 0;
    }
    const {position, lineDistance} = geometry.attributes;  // dashes depend on the distance along the line
    for (let i = this.traced; i < n; ++i) {
      const p = [0, 1, 2].map((k) => frames.at(this.base + P + k, i));
      position.setXYZ(i, ...p);
      const step = i && Math.hypot(p[0] - position.getX(i - 1), p[1] - position.getY(i - 1), p[2] - position.getZ(i - 1));
      lineDistance.setX(i, i && lineDistance.getX(i - 1) + step);
    }
    this.traced = n;
    position.needsUpdate = lineDistance.needsUpdate = true;
    geometry.setDrawRange(0, n);
  }

  // The largest distance of a point of the solid from its centre.
  reach() {
    const [x, y, z] = this.shape.size;
    if (this.shape.kind === 'mesh') return this.meshReach;
    return this.shape.kind === 'box' ? Math.hypot(x, y, z) / 2 : x + y / 2;
  }

  // Points that bound the shape in a frame; none if it is invisible.
  points(frame) {
    const read = (column) => new THREE.Vector3(...[0, 1, 2].map((k) => this.frames.at(this.base + column + k, frame)));
    if (this.frames.at(this.base + VISIBLE, frame) === 0) return [];
    const p = read(P);
    if (this.shape.kind === 'segment') return [p, read(VECTOR).add(p)];
    if (this.shape.kind === 'trace' || this.shape.kind === 'arrow') return [p];
    const [x, y, z] = this.shape.size;
    if (this.shape.kind === 'sphere') return [p.clone().addScalar(x), p.subScalar(x)];
    const half = this.shape.kind === 'box' ? [x / 2, y / 2, z / 2] : [x, x, y / 2 + (this.shape.kind === 'capsule' ? x : 0)];
    const {min, max} = this.meshBox || {max: new THREE.Vector3(...half), min: new THREE.Vector3(...half).negate()};
    const q = this.attitude(frame);
    return cornersOf({min, max}).map((corner) => corner.applyQuaternion(q).add(p));
  }

  // The z axis of the shape in a frame.
  normal(frame) {
    return new THREE.Vector3(0, 0, 1).applyQuaternion(this.attitude(frame));
  }
  attitude(frame) {
    return new THREE.Quaternion(...[1, 2, 3, 0].map((k) => this.frames.at(this.base + Q + k, frame)));
  }

  // False for shapes that are always hidden and for forces that are always zero.
  everSeen() {
    const {frames, base, shape} = this;
    const vector = shape.kind === 'segment' || shape.kind === 'arrow';
    for (let i = 0; i < frames.time.length; ++i) {
      if (frames.at(base + VISIBLE, i) === 0) continue;
      if (!vector || [0, 1, 2].some((k) => frames.at(base + VECTOR + k, i) !== 0)) return true;
    }
    return false;
  }

  setOpacity(opacity) {
    if (this.hidden) this.hidden.opacity = 0.5 * opacity;
    for (const material of [this.material, this.edges]) {
      if (!material) continue;
      material.transparent = opacity < 1;
      material.opacity = opacity;
      material.depthWrite = opacity === 1;
    }
  }

  update() {
    const {frames, base, object} = this;
    object.visible = frames.at(base + VISIBLE, frames.a) !== 0;
    frames.vector(base + P, object.position);
    if (this.range) {
      const [low, high] = this.range;
      const [r, g, b] = scaleColor(high > low ? (frames.value(base + VALUE) - low) / (high - low) : 0.5);
      this.material.color.setRGB(r / 255, g / 255, b / 255);
    }
    if (this.shape.kind === 'segment' || this.shape.kind === 'arrow') {
      this.updateVector();
    } else if (this.shape.kind !== 'trace') {
      frames.quaternion(base + Q, object.quaternion);
    }
  }

  updateVector() {
    const vector = this.frames.vector(this.base + VECTOR, Actor.scratch);
    const arrow = this.shape.kind === 'arrow';
    const length = vector.length() * (arrow ? Math.abs(this.shape.scale) : 1);
    if (arrow && this.shape.scale < 0) vector.negate();
    if (length < 1e-6) {
      this.object.visible = false;
      return;
    }
    this.object.quaternion.setFromUnitVectors(Actor.y, vector.normalize());
    if (!arrow) {
      const radius = this.shape.size[0];
      this.object.children[0].scale.set(radius, length, radius);
      this.object.children[0].position.y = length / 2;
      return;
    }
    const head = Math.min(0.35 * length, 4 * this.arrowRadius);
    this.head.scale.set(0.45 * head, head, 0.45 * head);
    this.head.position.y = length - head / 2;
    this.shaft.scale.set(0.16 * head, length - head, 0.16 * head);
    this.shaft.position.y = (length - head) / 2;
  }
}
