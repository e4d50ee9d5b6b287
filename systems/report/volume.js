// The page of a volume: a table of figures, the surface of the region in which a condition holds, and slices through it.
//
// A program can inspect the page through window.tenonVolume: ready (everything is drawn), `webgl` (whether there is a surface),
// replay (a Replay, or null), faces (number of faces of the surface), show(index of a map), colour(index of a quantity),
// slice(axis, index), state(i, j, k) of a cell.

(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const find = (selector) => document.querySelector(selector);
  const FAILS = 0, UNDECIDED = 1, HOLDS = 2, UNDECIDED_COLOR = '#ead9b0';
  const SLICES = [{normal: 2, across: 0, up: 1}, {normal: 1, across: 0, up: 2}, {normal: 0, across: 1, up: 2}];

  // A map, with the part to which each cell belongs.
  class Volume {
    constructor(json) {
      Object.assign(this, json);
      const width = 7 + json.quantities.length, rows = decode(json.parts, Float32Array);
      this.width = width;
      this.rows = rows;
      const [nx, ny, nz] = this.cells;
      this.part = new Int32Array(nx * ny * nz).fill(-1);
      for (let row = 0; row * width < rows.length; ++row) {
        const [i0, j0, k0, ni, nj, nk] = rows.subarray(row * width, row * width + 6);
        for (let k = k0; k < k0 + nk; ++k)
          for (let j = j0; j < j0 + nj; ++j) this.part.fill(row, i0 + nx * (j + ny * k), i0 + ni + nx * (j + ny * k));
      }
      this.cell = [0, 1, 2].map((a) => (this.high[a] - this.low[a]) / this.cells[a]);
      this.frames = Recording.read(json).frames;
    }
    at(c) {
      if (c.some((index, a) => index < 0 || index >= this.cells[a])) return -1;
      return this.part[c[0] + this.cells[0] * (c[1] + this.cells[1] * c[2])];
    }
    state(c) {
      const row = this.at(c);
      return row < 0 ? FAILS : this.rows[row * this.width + 6];
    }
    value(row, quantity) {
      return this.rows[row * this.width + 7 + quantity];
    }
    // The range of a quantity over cells that hold, from the 1st to the 99th percentile, so outliers do not stretch the colours.
    range(quantity) {
      const values = [];
      for (let row = 0; row * this.width < this.rows.length; ++row) {
        const value = this.value(row, quantity);
        if (this.rows[row * this.width + 6] === HOLDS && Number.isFinite(value)) values.push(value);
      }
      values.sort((a, b) => a - b);
      return values.length ? [0.01, 0.99].map((share) => values[Math.floor(share * (values.length - 1))]) : [0, 1];
    }
    color(row) {
      const [low, high] = this.shown, value = this.value(row, this.quantity);
      if (!Number.isFinite(value)) return [150, 150, 150];
      return scaleColor(high > low ? (value - low) / (high - low) : 0.5);
    }
    place(index, a) {
      return this.low[a] + index * this.cell[a];
    }
    // The faces between cells that hold and other cells, as triangles.
    surface() {
      const points = [], normals = [], colors = [];
      this.faces = 0;
      for (let k = 0; k < this.cells[2]; ++k)
        for (let j = 0; j < this.cells[1]; ++j)
          for (let i = 0; i < this.cells[0]; ++i) {
            if (this.state([i, j, k]) !== HOLDS) continue;
            const color = this.color(this.at([i, j, k])).map((c) => c / 255);
            for (let a = 0; a < 3; ++a)
              for (const side of [0, 1]) {
                const next = [i, j, k];
                next[a] += side ? 1 : -1;
                if (this.state(next) === HOLDS) continue;
                ++this.faces;
                const b = (a + 1) % 3, c = (a + 2) % 3;
                const corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([u, v]) => {
                  const corner = [i, j, k];
                  corner[a] += side;
                  corner[b] += u;
                  corner[c] += v;
                  return corner.map((index, axis) => this.place(index, axis));
                });
                for (const corner of side ? [0, 1, 2, 0, 2, 3] : [0, 2, 1, 0, 3, 2]) {
                  points.push(...corners[corner]);
                  normals.push(...[0, 1, 2].map((axis) => (axis === a ? (side ? 1 : -1) : 0)));
                  colors.push(...color);
                }
              }
          }
      const geometry = new THREE.BufferGeometry();
      for (const [name, values] of [['position', points], ['normal', normals], ['color', colors]])
        geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(values), 3));
      return geometry;
    }
  }

  const volumes = data.maps.map((map) => new Volume(map));
  let shown = 0, replay = null;
  const cuts = volumes.map((volume) => volume.cells.map((count) => Math.floor(count / 2)));
  const current = () => volumes[shown];

  function showHeader() {
    document.title = data.title;
    find('h1').textContent = data.title;
    find('#headline p').textContent = data.description;
    showFigures(find('#figures'), [{figures: data.figures.map(([name, value]) => ({name, value}))}]);
  }

  function showChoosers() {
    const parent = find('#choosers');
    parent.replaceChildren();
    if (volumes.length > 1) chooser(parent, 'show', volumes.map((volume) => volume.title), shown, show);
    if (current().quantities.length) chooser(parent, 'colour', current().quantities.map(label), current().quantity, colour);
  }

  function showColours() {
    const [low, high] = current().shown, bar = find('#colorbar');
    const unit = current().quantities.length ? nameOfKey(current().quantities[current().quantity]).unit : '';
    bar.hidden = !current().quantities.length;
    bar.firstElementChild.textContent = formatNumber(low);
    bar.lastElementChild.textContent = `${formatNumber(high)} ${unit}`;
    bar.querySelector('i').style.background = `linear-gradient(90deg, ${SCALE.map((c) => `rgb(${c.join(',')})`).join(', ')})`;
    const key = find('#key');
    key.replaceChildren();
    const swatch = element('span', 'swatch');
    swatch.style.background = UNDECIDED_COLOR;
    key.append('The condition holds everywhere in coloured cells. ', swatch, 'Undecided: it may fail in a part of the cell. It fails everywhere in cells without colour.');
  }

  function drawSlice(canvas, slice) {
    const volume = current(), {normal, across, up} = slice;
    const w = volume.high[across] - volume.low[across], h = volume.high[up] - volume.low[up];
    const left = 46, bottom = 30, width = canvas.parentElement.clientWidth || 560;
    const scale = Math.min((width - left - 10) / w, 300 / h), ratio = Math.min(window.devicePixelRatio || 1, 2);
    const height = scale * h + bottom + 8;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    const pen = canvas.getContext('2d');
    pen.scale(ratio, ratio);
    const x = (place) => left + scale * (place - volume.low[across]), y = (place) => 6 + scale * (volume.high[up] - place);
    pen.fillStyle = Theme.color('--panel');
    pen.fillRect(x(volume.low[across]), 6, scale * w, scale * h);
    const cell = [0, 0, 0];
    cell[normal] = cuts[shown][normal];
    for (let j = 0; j < volume.cells[up]; ++j)
      for (let i = 0; i < volume.cells[across]; ++i) {
        cell[across] = i;
        cell[up] = j;
        const state = volume.state(cell);
        if (state === FAILS) continue;
        pen.fillStyle = state === UNDECIDED ? UNDECIDED_COLOR : `rgb(${volume.color(volume.at(cell)).join(',')})`;
        const x0 = x(volume.place(i, across)), y0 = y(volume.place(j + 1, up));
        pen.fillRect(x0, y0, scale * volume.cell[across] + 0.6, scale * volume.cell[up] + 0.6);
      }
    pen.strokeStyle = Theme.color('--axis');
    pen.strokeRect(x(volume.low[across]), 6, scale * w, scale * h);
    pen.fillStyle = Theme.color('--soft');
    pen.font = '11px system-ui, sans-serif';
    pen.textAlign = 'center';
    for (const place of ticks(volume.low[across], volume.high[across], 8)) pen.fillText(formatNumber(place), x(place), scale * h + 20);
    pen.fillText(label(volume.coordinates[across]), x((volume.low[across] + volume.high[across]) / 2), scale * h + 33);
    pen.textAlign = 'right';
    for (const place of ticks(volume.low[up], volume.high[up], 6)) pen.fillText(formatNumber(place), left - 5, y(place) + 4);
    pen.save();
    pen.translate(10, 6 + scale * h / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = 'center';
    pen.fillText(label(volume.coordinates[up]), 0, 0);
    pen.restore();
    canvas.onmousemove = (event) => {
      const c = [0, 0, 0];
      c[normal] = cuts[shown][normal];
      c[across] = Math.floor((event.offsetX - left) / scale / volume.cell[across]);
      c[up] = Math.floor((volume.high[up] - volume.low[up] - (event.offsetY - 6) / scale) / volume.cell[up]);
      const row = volume.at(c);
      find('#readout').textContent = row < 0 ? '' :
        `${volume.coordinates.map((name, a) => `${nameOfKey(name).name} = ${formatNumber(volume.place(c[a] + 0.5, a))}`).join(', ')}: ` +
        `${['fails', 'undecided', 'holds'][volume.state(c)]}` +
        volume.quantities.map((name, q) => Number.isFinite(volume.value(row, q)) ? `, ${nameOfKey(name).name} ${formatNumber(volume.value(row, q))} ${nameOfKey(name).unit}` : '').join('');
    };
  }

  // About `count` round numbers between low and high.
  function ticks(low, high, count) {
    const raw = (high - low) / count, power = Math.pow(10, Math.floor(Math.log10(raw)));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
    const found = [];
    for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; ++n) found.push(Number((n * step).toPrecision(10)));
    return found;
  }

  function showSlices() {
    const parent = find('#slices');
    parent.replaceChildren();
    for (const slice of SLICES) {
      const volume = current(), figure = element('figure', 'slice');
      const caption = element('label', 'chooser'), text = element('span'), slider = element('input');
      const canvas = element('canvas');
      Object.assign(slider, {type: 'range', min: 0, max: volume.cells[slice.normal] - 1, step: 1, value: cuts[shown][slice.normal]});
      const draw = () => {
        const {name, unit} = nameOfKey(volume.coordinates[slice.normal]);
        text.textContent = `${name} = ${formatNumber(volume.place(cuts[shown][slice.normal] + 0.5, slice.normal))} ${unit} `;
        drawSlice(canvas, slice);
      };
      slider.oninput = () => {
        cuts[shown][slice.normal] = Number(slider.value);
        draw();
      };
      caption.append(text, slider);
      figure.append(caption, canvas);
      parent.append(figure);
      draw();
    }
  }

  function showSurface() {
    if (!replay) return;
    volumes.forEach((volume, i) => {
      if (volume.mesh) {
        replay.runs[i].group.remove(volume.mesh);
        volume.mesh.geometry.dispose();
      }
      volume.mesh = null;
    });
    const material = new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, side: THREE.DoubleSide, transparent: true, opacity: 0.6, shininess: 5});
    current().mesh = new THREE.Mesh(current().surface(), material);
    replay.runs[shown].group.add(current().mesh);
    replay.requestRender();
  }

  function show(index) {
    shown = index;
    if (replay) {
      const {low, high} = current(), shapes = new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high));
      for (const actor of replay.runs[index].actors)
        for (const point of actor.points(0)) shapes.expandByPoint(point);
      replay.shown = index;
      replay.home = shapes;
      replay.setTime(0);
      replay.resetView();
    }
    colour(current().quantity);
  }

  function colour(quantity) {
    current().quantity = quantity;
    current().shown = current().quantities.length ? current().range(quantity) : [0, 1];
    showChoosers();
    showColours();
    showSlices();
    showSurface();
  }

  showHeader();
  for (const volume of volumes) volume.quantity = 0;
  // The surface fills the part of the window below the header and the figures.
  const fit = () => document.documentElement.style.setProperty('--top', `${find('main').offsetTop}px`);
  fit();
  for (const part of ['header', '#figures']) new ResizeObserver(fit).observe(find(part));
  try {
    replay = new Replay(find('#stage'), volumes);
    replay.speck = false;  // no close-up, because the surface would hide its content
    replay.resize();
  } catch (error) {
    if (error.message !== 'no WebGL') throw error;
    find('#no-webgl').hidden = false;
  }
  if (volumes.length) show(0);
  window.addEventListener('resize', showSlices);
  find('#theme').onclick = Theme.toggle;
  Theme.onChange(showSlices);
  window.tenonVolume = {
    ready: true, data, webgl: replay !== null, replay, show, colour,
    get faces() { return current().faces; },
    state: (i, j, k) => current().state([i, j, k]),
    slice: (axis, index) => {
      cuts[shown][axis] = index;
      showSlices();
    },
  };
})();
