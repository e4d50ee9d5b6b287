// The current frame of the replay as a vector picture. Shapes are projected as polygons and drawn from the farthest to the
// nearest: boxes by face, meshes by triangle, round shapes by their outline.

'use strict';

// The corners of the convex outline of points {x, y} in a plane, by Andrew's monotone chain.
function outlineOf(points) {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  const half = (list) => {
    const chain = [];
    for (const p of list) {
      for (; chain.length > 1; chain.pop()) {
        const [a, b] = chain.slice(-2);
        if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0) break;
      }
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

// Draws the scene as the camera sees it into a picture of this size. `id` distinguishes the colour gradients of two scenes.
function drawScene(parent, replay, camera, width, height, id) {
  replay.scene.updateMatrixWorld();
  camera.updateMatrixWorld();
  const view = new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, new THREE.Matrix4().getInverse(camera.matrixWorld));
  const near = 0.02 * camera.position.distanceTo(replay.bodyPlace() || replay.controls.target);
  const toView = (p) => new THREE.Vector4(p.x, p.y, p.z, 1).applyMatrix4(view);
  const toPicture = ({x, y, w}) => ({x: (x / w + 1) / 2 * width, y: (1 - y / w) / 2 * height, depth: w});
  const project = (points) => {
    const seen = points.map(toView);
    return seen.every(({w}) => w > near) ? seen.map(toPicture) : [];
  };
  const corners = (points) => points.map(({x, y}) => `${px(x)},${px(y)}`).join(' ');
  // A line with the part behind the camera cut off.
  const line = (group, from, to, attributes) => {
    const a = toView(from), b = toView(to);
    if (a.w < near && b.w < near) return;
    if (a.w < near) a.lerp(b, (near - a.w) / (b.w - a.w));
    if (b.w < near) b.lerp(a, (near - b.w) / (a.w - b.w));
    const [p, q] = [a, b].map(toPicture);
    if (Math.max(p.x, q.x) < 0 || Math.min(p.x, q.x) > width || Math.max(p.y, q.y) < 0 || Math.min(p.y, q.y) > height) return;
    shape(group, 'line', {x1: px(p.x), y1: px(p.y), x2: px(q.x), y2: px(q.y), ...attributes});
  };
  const worldPoints = (mesh) => {
    const {position} = mesh.geometry.attributes;
    return Array.from({length: position.count}, (_, i) => mesh.localToWorld(new THREE.Vector3().fromBufferAttribute(position, i)));
  };

  const grid = shape(parent, 'g', {'stroke-width': 0.8}), ends = worldPoints(replay.grid);
  const tint = (i) => replay.grid.geometry.attributes.color.getX(i);
  for (let i = 0; i + 1 < ends.length; i += 2) line(grid, ends[i], ends[i + 1], {stroke: Theme.color(tint(i) === tint(0) ? '--grid' : '--axis')});
  const ground = shape(parent, 'g', {}), shadows = shape(parent, 'g', {opacity: 0.14});
  const traces = shape(parent, 'g', {fill: 'none', 'stroke-width': 1.3}), solids = shape(parent, 'g', {'stroke-linejoin': 'round'});
  const defs = shape(parent, 'defs', {}), gradients = new Map();
  const sun = replay.sun.position.clone().sub(replay.sun.target.position).normalize();
  const shaded = (color, factor) => `#${color.clone().multiplyScalar(factor).getHexString()}`;
  // The reference of a gradient from the lit to the dark side of a round shape.
  const gradientOf = (color, ball) => {
    const key = color.getHexString() + (ball ? '-ball' : '');
    if (!gradients.has(key)) {
      const gradient = shape(defs, ball ? 'radialGradient' : 'linearGradient',
                             {id: `${id}-${key}`, ...(ball ? {cx: 0.38, cy: 0.32, r: 0.7} : {x1: 0, y1: 0, x2: 0.8, y2: 1})});
      [[0, 1.25], [0.45, 1], [1, 0.6]].forEach(([offset, factor]) => shape(gradient, 'stop', {offset, 'stop-color': shaded(color, factor)}));
      gradients.set(key, `url(#${id}-${key})`);
    }
    return gradients.get(key);
  };

  const polygons = [];  // {depth, group, points, attributes}
  const add = (actor, points, attributes) => {
    if (points.length < 3) return;
    const depth = points.reduce((sum, p) => sum + p.depth, 0) / points.length;
    polygons.push({depth, arrow: actor.shape.kind === 'arrow', group: actor.shape.role === 'ground' ? ground : solids, points: corners(points), attributes: {...attributes, opacity: actor.material.opacity}});
  };
  const addFaces = (actor, points, faces, closed, colors) => {
    for (const face of faces) {
      const color = colors ? new THREE.Color().fromArray(colors, 3 * face[0]) : actor.material.color;
      const [a, b, c] = face.map((i) => points[i]), normal = b.clone().sub(a).cross(c.clone().sub(a)).normalize();
      const away = normal.dot(camera.position.clone().sub(a)) < 0;
      if (closed && away) continue;
      if (away) normal.negate();
      const fill = shaded(color, 0.72 + 0.4 * Math.max(0, normal.dot(sun)));
      add(actor, project(face.map((i) => points[i])), {fill, stroke: closed ? shaded(color, 0.55) : fill, 'stroke-width': closed ? 0.7 : 0.4});
    }
  };
  const addActor = (actor) => {
    const meshes = actor.object.children.filter((child) => child.isMesh), {kind, role} = actor.shape, {color} = actor.material;
    const sets = meshes.map(worldPoints), all = sets.flat();
    if (kind === 'box') {
      addFaces(actor, all, [0, 4, 8, 12, 16, 20].map((i) => [i, i + 2, i + 3, i + 1]), true);
    } else if (kind === 'mesh') {
      const {array} = meshes[0].geometry.index, colors = meshes[0].geometry.attributes.color;
      addFaces(actor, all, Array.from({length: array.length / 3}, (_, i) => [...array.slice(3 * i, 3 * i + 3)]), false, colors && colors.array);
    } else {
      // Long thin shapes are cut into pieces, so that each has the right depth.
      for (const points of kind === 'segment' ? piecesOf(actor) : kind === 'arrow' ? sets : [all]) {
        const seen = project(points);
        add(actor, outlineOf(seen), {fill: gradientOf(color, kind === 'sphere' || kind === 'trace'), ...(kind === 'segment' ? {fill: shaded(color, 1), stroke: shaded(color, 1), 'stroke-width': 0.8} : {})});
      }
    }
    if (role === 'ground' || !all.length) return;
    const fallen = project(all.filter((p) => p.z > -1e-3).map((p) => p.clone().addScaledVector(sun, -p.z / sun.z)));
    if (fallen.length > 2) shape(shadows, 'polygon', {points: corners(outlineOf(fallen))});
  };
  // The points that bound the pieces of the part of a segment that is before the camera.
  function piecesOf(actor) {
    const mesh = actor.object.children[0], count = 12;
    const point = (y, angle, radius) => mesh.localToWorld(new THREE.Vector3(radius * Math.sin(angle), y, radius * Math.cos(angle)));
    const [a, b] = [-0.5, 0.5].map((y) => toView(point(y, 0, 0)).w - 1.5 * near), zero = a / (a - b) - 0.5;
    if (a < 0 && b < 0) return [];
    const [from, to] = [a < 0 ? zero : -0.5, b < 0 ? zero : 0.5];
    const ring = (i) => Array.from({length: 8}, (_, k) => point(from + (to - from) * i / count, k * Math.PI / 4, 1));
    return Array.from({length: count}, (_, i) => [...ring(i), ...ring(i + 1)]);
  }

  for (const run of replay.runs.filter(({group}) => group.visible)) {
    for (const actor of run.actors) {
      if (actor.line && actor.line.visible) {
        const {position} = actor.line.geometry.attributes;
        const seen = project(Array.from({length: actor.traced}, (_, i) => new THREE.Vector3().fromBufferAttribute(position, i)));
        const apart = seen.filter((p, i) => i === 0 || i % 8 === 0 || i === seen.length - 1 || Math.hypot(p.x - seen[i - 1].x, p.y - seen[i - 1].y) > 1);
        if (apart.length > 1) shape(traces, 'polyline', {points: corners(apart), stroke: shaded(actor.edges.color, 1), 'stroke-dasharray': actor.shape.role === 'reference' ? '5 4' : 'none', opacity: actor.edges.opacity});
      }
      if (actor.object.visible) addActor(actor);
    }
  }
  polygons.sort((a, b) => b.depth - a.depth);
  for (const {group, points, attributes} of polygons) shape(group, 'polygon', {points, ...attributes});
  // Arrows shine through the bodies.
  for (const {arrow, points, attributes} of polygons)
    if (arrow) shape(solids, 'polygon', {points, ...attributes, opacity: 0.5 * attributes.opacity});
}

// Draws time, names of the shapes, scale and colour bar over a picture of the replay, by a context of a canvas or of SVG.
function drawNotes(context, replay, time, width, height) {
  const size = Math.max(11, Math.round(Math.min(width, 1.6 * height) / 55)), soft = Theme.color('--soft'), ink = Theme.color('--ink');
  const wide = (text) => context.measureText(text).width;
  const put = (text, x, y, color) => {
    context.fillStyle = color;
    context.fillText(text, x, y);
  };
  const scale = (left, top, length) => {  // the colours from low to high values
    for (let i = 0; i < 40; ++i) {
      context.fillStyle = `rgb(${scaleColor(i / 39).join(',')})`;
      context.fillRect(left + i * length / 40, top, Math.min(length / 20, (40 - i) * length / 40), 0.8 * size);
    }
  };
  context.font = `${size}px sans-serif`;
  const clock = `${time.toFixed(2)} s`, right = width - wide(clock) - size;
  put(clock, right, 1.6 * size, ink);
  let x = size, y = 1.6 * size;
  for (const role of replay.roles.filter((r) => !replay.hiddenRoles.has(r))) {
    const color = replay.colorOf(role), room = wide(role) + 2.2 * size;
    if (x > size && x + room > right) [x, y] = [size, y + 1.6 * size];
    if (color) context.fillStyle = color;
    if (color) context.fillRect(x, y - 0.75 * size, 0.8 * size, 0.8 * size);
    else scale(x, y - 0.75 * size, 0.8 * size);
    put(role, x + 1.1 * size, y, soft);
    x += room;
  }
  const left = size + (replay.inset.size ? replay.inset.size + 10 : 0);
  put(`grid ${formatNumber(replay.surroundings.cell)} m`, left, height - 0.9 * size, soft);
  const [unit, [low, high]] = Object.entries(replay.ranges)[0] || ['', [0, 0]];
  if (unit) {
    const start = formatNumber(low), end = `${formatNumber(high)} ${unit}`, length = 7 * size, from = width - wide(end) - length - 1.5 * size;
    scale(from, height - 1.65 * size, length);
    put(end, from + length + 0.5 * size, height - 0.9 * size, soft);
    put(start, from - wide(start) - 0.5 * size, height - 0.9 * size, soft);
  }
  if (replay.inset.size) {
    const [a, b, c, d] = [10, height - 10 - replay.inset.size, 10 + replay.inset.size, height - 10];
    context.strokeStyle = Theme.color('--axis');
    context.lineWidth = 1;
    context.beginPath();
    for (const [i, [u, v]] of [[a, b], [c, b], [c, d], [a, d], [a, b]].entries()) i ? context.lineTo(u, v) : context.moveTo(u, v);
    context.stroke();
  }
}

// Returns an SVG element with the current frame of the replay, titled for readers of the file.
function pictureOfReplay(replay, title, time) {
  return Theme.onPaper(() => {
    const {width, height} = replay.size, {size} = replay.inset, drawing = svg(null, width, height);
    shape(drawing, 'title', {}, `${title}, ${time.toFixed(3)} s`);
    drawScene(drawing, replay, replay.camera, width, height, 'scene');
    if (replay.placeInset()) {
      const inset = shape(drawing, 'svg', {x: 10, y: height - 10 - size, width: size, height: size});
      shape(inset, 'rect', {width: size, height: size, fill: '#fff'});
      drawScene(inset, replay, replay.inset.camera, size, size, 'inset');
    }
    drawNotes(new SvgContext(drawing), replay, time, width, height);
    return drawing;
  });
}
