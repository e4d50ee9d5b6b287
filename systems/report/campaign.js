// The page of a campaign: survival, map, distributions, influence of the varied keys, causes of failure, notable runs.
//
// A program can inspect the page through window.tenonCampaign: ready (everything is drawn), data, pictures() (a [title, text of
// an SVG file] for each drawing).

(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const find = (selector) => document.querySelector(selector);
  const percent = (share) => `${Number((100 * share).toPrecision(4))} %`;

  function hint(node, text) {
    shape(node, 'title', {}, text);
    return node;
  }

  // Colour for a share from 0, almost white, to 1, the dark accent colour.
  function tone(share) {
    const mix = (from, to) => Math.round(from + (to - from) * share);
    return `rgb(${mix(236, 18)}, ${mix(243, 78)}, ${mix(250, 140)})`;
  }
  // Colour for a share: red for 0, yellow for 0.5, green for 1.
  function traffic(share) {
    const stops = [[179, 38, 30], [232, 184, 74], [27, 127, 75]];
    const at = Math.min(Math.max(share, 0), 1) * 2, i = Math.min(Math.floor(at), 1);
    return `rgb(${stops[i].map((from, c) => Math.round(from + (stops[i + 1][c] - from) * (at - i))).join(', ')})`;
  }

  function showHeader() {
    find('h1').textContent = data.title;
    find('#headline p').textContent = data.description;
    const { survived, count, low, high } = data.survival;
    if (data.limits.length) return find('#verdicts').append(element('span', 'verdict', `${count} runs to find limits`));
    const text = `${survived} of ${count} survived: ${count ? percent(survived / count) : '–'}, ` +
      `${percent(low)} to ${percent(high)} with ${percent(data.confidence)} confidence`;
    find('#verdicts').append(element('span', `verdict ${count && survived === count ? 'good' : survived ? '' : 'bad'}`, text));
  }

  const nameOf = (point) => point.at.map((l, a) => `${data.axes[a].name} = ${data.axes[a].labels[l]}`).join(', ') || 'all';

  function showSurvival() {
    const parent = find('#survival');
    if (data.limits.length || !data.points.length) {
      parent.hidden = true;
      return;
    }
    const shown = data.points.slice(0, 40);
    if (data.axes.filter((axis) => axis.labels.length > 1).length > 1) find('#picks').after(parent);  // with several axes, the map is the better overview
    const titles = shown.map((point) => nameOf(point).slice(-60)), left = 20 + 6.6 * Math.max(...titles.map((title) => title.length), 4);
    const width = 1000, row = 20, plot = width - left - 170;
    const drawing = svg(parent, width, 24 + row * shown.length);
    const x = (share) => left + plot * share;
    for (let tick = 0; tick <= 4; ++tick) {
      shape(drawing, 'line', { x1: x(tick / 4), x2: x(tick / 4), y1: 16, y2: 20 + row * shown.length, class: 'grid' });
      shape(drawing, 'text', { x: x(tick / 4), y: 11, 'text-anchor': 'middle' }, percent(tick / 4));
    }
    shown.forEach((point, i) => {
      const y = 30 + row * i, share = point.survived / point.count;
      shape(drawing, 'text', { x: left - 8, y: y + 4, 'text-anchor': 'end' }, titles[i]);
      shape(drawing, 'line', { x1: x(point.low), x2: x(point.high), y1: y, y2: y, stroke: traffic(share), 'stroke-width': 7, opacity: 0.35 });
      hint(shape(drawing, 'circle', { cx: x(share), cy: y, r: 4.5, fill: traffic(share) }), `${nameOf(point)}: ${percent(point.low)} to ${percent(point.high)}`);
      shape(drawing, 'text', { x: x(1) + 12, y: y + 4 }, `${point.survived} of ${point.count}, ${percent(share)}`);
    });
    if (data.points.length > shown.length)
      parent.append(element('p', 'note', `${data.points.length - shown.length} more points are in runs.csv${data.axes.length > 1 ? ' and on the map' : ''}.`));
  }

  // Shows survival, or the median of a figure, over two of the axes, averaged over the others.
  function showMap() {
    if (data.limits.length || !data.points.length || data.axes.filter((axis) => axis.labels.length > 1).length < 2) return;
    const parent = find('#map');
    parent.hidden = false;
    const names = data.axes.map((axis) => axis.name);
    const wide = names.map((_, a) => a).filter((a) => data.axes[a].labels.length > 1);
    let xAxis = wide[1], yAxis = wide[0], what = 0;
    const choices = element('p', 'choosers'), area = element('div');
    chooser(choices, 'across', names, xAxis, (a) => { xAxis = a; draw(); });
    chooser(choices, 'up', names, yAxis, (a) => { yAxis = a; draw(); });
    chooser(choices, 'colour', ['survival', ...(data.points[0].medians.length ? data.figures.map(label) : [])], what, (w) => { what = w; draw(); });
    parent.append(choices, area);
    function draw() {
      area.replaceChildren();
      const across = data.axes[xAxis].labels, up = data.axes[yAxis].labels;
      const cells = across.map(() => up.map(() => ({ sum: 0, weight: 0, missing: 0 })));
      for (const point of data.points) {
        const value = what === 0 ? point.survived / point.count : point.medians[what - 1];
        const cell = cells[point.at[xAxis]][point.at[yAxis]];
        if (what > 0) cell.missing += point.missing[what - 1];
        if (value === null) continue;
        cell.sum += value * point.count;
        cell.weight += point.count;
      }
      const values = cells.flat().filter((cell) => cell.weight).map((cell) => cell.sum / cell.weight);
      const low = what === 0 ? 0 : Math.min(...values), high = what === 0 ? 1 : Math.max(...values);
      const titles = up.map((text) => text.slice(0, 40)), left = 20 + 7 * Math.max(...titles.map((title) => title.length));
      const width = Math.max(560, left + 428);
      const w = Math.min(90, (width - left) / across.length), h = Math.min(34, Math.max(14, 360 / up.length));
      const drawing = svg(area, width, h * up.length + 54);
      up.forEach((text, j) => {
        const y = h * (up.length - 1 - j);
        shape(drawing, 'text', { x: left - 6, y: y + h / 2 + 4, 'text-anchor': 'end' }, titles[j]);
        across.forEach((_, i) => {
          const cell = cells[i][j];
          if (!cell.weight) return;
          const value = cell.sum / cell.weight, share = high > low ? (value - low) / (high - low) : 1;
          const box = shape(drawing, 'rect', { x: left + w * i, y, width: w - 1, height: h - 1, fill: what === 0 ? traffic(share) : tone(share) });
          hint(box, `${names[xAxis]} = ${across[i]}, ${names[yAxis]} = ${text}: ${what === 0 ? percent(value) : formatNumber(value)}${cell.missing ? ` (${cell.missing} runs without a number)` : ''}`);
          if (w > 38) shape(drawing, 'text', { x: left + w * (i + 0.5), y: y + h / 2 + 4, 'text-anchor': 'middle', class: (what === 0 ? share < 0.25 || share > 0.75 : share > 0.5) ? 'white' : 'dark' }, what === 0 ? `${Math.round(100 * value)} %` : formatNumber(value));
        });
      });
      across.forEach((text, i) => {
        if (across.length < 13 || i % Math.ceil(across.length / 12) === 0)
          shape(drawing, 'text', { x: left + w * (i + 0.5), y: h * up.length + 14, 'text-anchor': 'middle' }, text.slice(0, 12));
      });
      shape(drawing, 'text', { x: left + w * across.length / 2, y: h * up.length + 34, 'text-anchor': 'middle', class: 'soft' }, label(names[xAxis]));
      shape(drawing, 'text', { x: 2, y: h * up.length + 48, class: 'soft' }, `up: ${label(names[yAxis])}`);
    }
    draw();
  }

  function table(parent, head, rows) {
    const node = element('table');
    const first = node.createTHead().insertRow();
    head.forEach((text) => first.append(element('th', '', text)));
    const body = node.createTBody();
    for (const row of rows) {
      const line = body.insertRow();
      row.forEach((cell) => {
        const place = line.insertCell();
        if (cell instanceof Node) place.append(cell); else place.textContent = cell;
      });
    }
    parent.hidden = false;
    parent.append(node);
  }

  function showLimits() {
    if (!data.limits.length) return;
    table(find('#limits'), ['', `${label(data.limitKey)}: survived`, 'failed'],
      data.limits.map((limit) => [limit.point || 'all', formatNumber(limit.survives), formatNumber(limit.fails)]));
  }

  function showCauses() {
    if (!data.causes.length) return;
    const most = data.causes[0].count;
    table(find('#causes'), ['runs', 'cause', 'first'], data.causes.slice(0, 40).map(({ cause, count, first }) => {
      const bar = element('span', 'bar', String(count));
      bar.style.backgroundSize = `${(100 * count) / most}% 100%`;
      return [bar, cause, first.join(', ')];
    }));
  }

  function showPicks() {
    if (!data.picks.length) return;
    table(find('#picks'), ['run', 'reason', 'command that repeats it, with all logs and a report'], data.picks.map((pick) => {
      let run = document.createTextNode(String(pick.run));
      if (pick.link) {
        run = element('a', '', `${pick.run} (report)`);
        run.href = pick.link;
      }
      return [run, pick.why, element('code', '', pick.command)];
    }));
  }

  // Figures with more than one value.
  const telling = data.figures.map((_, f) => f).filter((f) => data.histograms[f] && data.histograms[f].high > data.histograms[f].low);

  function showMatters() {
    if (!data.correlations.length) return;
    const parent = find('#matters');
    const score = (f) => Math.max(...data.correlations.map((row) => Math.abs(row.values[f] ?? 0)));
    const columns = [data.figures.length, ...telling.filter((f) => !/^(wall|qp_time|mpc_time|real_time)/.test(data.figures[f])).sort((a, b) => score(b) - score(a)).slice(0, 9)]
      .filter((f) => data.correlations.some((row) => row.values[f] !== null));
    if (!columns.length) return;
    parent.hidden = false;
    const left = 20 + 6.6 * Math.max(...data.correlations.map((row) => Math.min(row.name.length, 40)));
    const w = 46, h = 24, top = 130;
    const drawing = svg(parent, left + w * columns.length + 110, top + h * data.correlations.length + 6);
    columns.forEach((f, i) => {
      const x = left + w * (i + 0.5);
      shape(drawing, 'text', { x, y: top - 8, transform: `rotate(-40 ${x} ${top - 8})` }, f === data.figures.length ? 'survival' : nameOfKey(data.figures[f]).name.slice(0, 26));
    });
    data.correlations.forEach((row, j) => {
      const y = top + h * j;
      shape(drawing, 'text', { x: left - 8, y: y + 16, 'text-anchor': 'end' }, row.name.slice(-40));
      columns.forEach((f, i) => {
        const value = row.values[f];
        if (value === null) return;
        const box = shape(drawing, 'rect', { x: left + w * i, y, width: w - 2, height: h - 2, class: value < 0 ? 'bad' : 'good', opacity: 0.08 + 0.8 * Math.abs(value) });
        hint(box, `${row.name} with ${f === data.figures.length ? 'survival' : data.figures[f]}: ${value.toFixed(3)}`);
        shape(drawing, 'text', { x: left + w * (i + 0.5) - 1, y: y + 15, 'text-anchor': 'middle', class: Math.abs(value) > 0.6 ? 'light' : '' }, value.toFixed(2));
      });
    });
  }

  // The text of a run for a tooltip, and a click that shows the command that repeats it below the drawing.
  function repeats(node, line, text = '') {
    hint(node, `run ${line.run}, seed ${line.seed}${text}`);
    node.onclick = () => {
      const card = node.closest('.card'), note = card.querySelector('.repeat') || card.appendChild(element('p', 'note repeat'));
      note.replaceChildren(`run ${line.run}, seed ${line.seed}${text}`);
      if (data.command) note.append(': ', element('code', '', `${data.command} --replay ${line.run}`));
    };
    return node;
  }

  // Runs as points over any two columns: varied keys and figures, coloured by a third.
  function showScatter() {
    const numeric = (labels) => labels.every((text) => text.trim() && Number.isFinite(Number(text)));
    const columns = [
      ...data.axes.map((axis, a) => numeric(axis.labels) ? { name: label(axis.name), of: (line) => Number(axis.labels[line.at[a]]) } :
        { name: axis.name, labels: axis.labels, of: (line) => line.at[a] }).filter((_, a) => data.axes[a].labels.length > 1),
      ...data.drawn.map((name, d) => ({ name: label(name), of: (line) => line.drawn[d] })),
      ...telling.map((f) => ({ name: label(data.figures[f]), of: (line) => line.figures[f] })),
    ];
    if (columns.length < 2 || data.lines.length < 2) return;
    const parent = find('#scatter'), choices = element('p', 'choosers'), place = element('div'), names = columns.map((column) => column.name);
    let x = 0, y = Math.max(1, names.findIndex((name) => /error max/.test(name))), color = 0;
    chooser(choices, 'across', names, x, (i) => { x = i; draw(); });
    chooser(choices, 'up', names, y, (i) => { y = i; draw(); });
    chooser(choices, 'colour', ['survival', ...names], color, (i) => { color = i; draw(); });
    parent.append(choices, place);
    parent.hidden = false;
    if (data.lines.length < data.survival.count) parent.append(element('p', 'note', `${data.lines.length} of ${data.survival.count} runs are drawn.`));

    const rangeOf = ({ of }) => {
      const values = data.lines.map(of).filter((value) => value !== null);
      return values.length ? [Math.min(...values), Math.max(...values)] : [0, 1];
    };
    const widened = ({ labels }, [low, high]) => {
      const margin = labels ? 0.5 : 0.04 * (high - low) || Math.abs(high) || 1;
      return [low - margin, high + margin];
    };
    const axisOf = (column) => ({ range: widened(column, rangeOf(column)), label: column.name, ticks: column.labels && column.labels.map((text, at) => ({ at, text })) });
    function draw() {
      const drawing = svg(null, 820, 420);
      const shade = color > 0 && columns[color - 1], bound = shade && rangeOf(shade);
      const mark = (parent, x, y, survived, paint) => shape(parent, 'path', {
        d: survived ? `M${px(x - 3)},${px(y)}a3,3 0 1 0 6,0a3,3 0 1 0 -6,0` : `M${px(x - 3)},${px(y - 3)}l6,6m0,-6l-6,6`,
        ...(paint ? { stroke: paint, fill: paint } : { class: survived ? 'dot' : 'dot bad' }), 'stroke-width': survived ? 0.5 : 1.6, opacity: 0.8 });
      const { toX, toY, area } = drawAxes(drawing, 820, 420, axisOf(columns[x]), axisOf(columns[y]), { top: 26, right: 14 });
      const paintOf = (value) => shade.labels ? Theme.series(value) : `rgb(${scaleColor((value - bound[0]) / (bound[1] - bound[0] || 1)).join(',')})`;
      for (const line of [...data.lines].sort((a, b) => b.survived - a.survived)) {
        const [u, v] = [columns[x].of(line), columns[y].of(line)], value = shade && shade.of(line);
        if (u === null || v === null || value === null) continue;
        repeats(mark(drawing, toX(u), toY(v), line.survived, shade && paintOf(value)), line, line.survived ? '' : ', failed');
      }
      let left = area.x;
      const key = (text, draw) => {
        draw(left + 5);
        shape(drawing, 'text', { x: left + 14, y: 15, class: 'soft' }, text);
        left += 34 + 6.2 * text.length;
      };
      key('survived', (at) => mark(drawing, at, 11, true, shade && '#888'));
      key('failed', (at) => mark(drawing, at, 11, false, shade && '#888'));
      if (shade && shade.labels) shade.labels.forEach((text, i) => key(text, (at) => mark(drawing, at, 11, true, Theme.series(i))));
      if (shade && !shade.labels) {
        const from = area.x + area.w - 150;
        for (let i = 0; i < 50; ++i) shape(drawing, 'rect', { x: from + 2 * i, y: 5, width: 2.3, height: 10, fill: `rgb(${scaleColor(i / 49).join(',')})` });
        shape(drawing, 'text', { x: from - 6, y: 14, 'text-anchor': 'end', class: 'soft' }, `${shade.name}: ${formatNumber(bound[0])}`);
        shape(drawing, 'text', { x: from + 106, y: 14, class: 'soft' }, formatNumber(bound[1]));
      }
      place.replaceChildren(drawing);
    }
    draw();
    Theme.onChange(draw);
  }

  // Parallel coordinates of the varied keys and the figures, with a line for each run.
  function showLines() {
    const keys = [
      ...data.axes.map((axis, a) => ({ name: axis.name, labels: axis.labels, of: (line) => line.at[a] })).filter((key) => key.labels.length > 1),
      ...data.drawn.map((name, d) => ({ name, of: (line) => line.drawn[d] })),
    ];
    const chosen = telling.filter((f) => /max|rms|mean|simulated/.test(data.figures[f])).slice(0, Math.max(3, 8 - keys.length));
    keys.push(...chosen.map((f) => ({ name: data.figures[f], of: (line) => line.figures[f] })));
    if (keys.length < 2 || data.lines.length < 2) return;
    const parent = find('#lines');
    parent.hidden = false;
    const width = 1000, height = 250, top = 40, step = (width - 120) / (keys.length - 1);
    const drawing = svg(parent, width, top + height + 24);
    for (const key of keys) {
      const values = data.lines.map(key.of).filter((value) => value !== null);
      key.low = key.labels ? 0 : Math.min(...values);
      key.high = key.labels ? key.labels.length - 1 : Math.max(...values);
    }
    const y = (key, value) => top + height * (1 - (key.high > key.low ? (value - key.low) / (key.high - key.low) : 0.5));
    const opacity = Math.min(0.7, Math.max(0.05, 40 / data.lines.length));
    for (const line of [...data.lines].sort((a, b) => b.survived - a.survived)) {
      let path = '';
      keys.forEach((key, i) => {
        const value = key.of(line);
        if (value !== null) path += `${path && keys[i - 1].of(line) !== null ? 'L' : 'M'}${(60 + step * i).toFixed(1)},${y(key, value).toFixed(1)}`;
      });
      repeats(shape(drawing, 'path', { d: path, class: line.survived ? 'run' : 'run bad', opacity: line.survived ? opacity : Math.min(1, 4 * opacity) }), line);
    }
    keys.forEach((key, i) => {
      const x = 60 + step * i;
      shape(drawing, 'line', { x1: x, x2: x, y1: top, y2: top + height, class: 'axis' });
      const name = label(key.name).slice(-30), room = 3.6 * name.length;  // half of the width of the name
      shape(drawing, 'text', { x: Math.min(Math.max(x, room), width - room), y: i % 2 ? 26 : 12, 'text-anchor': 'middle' }, name);
      if (key.labels) key.labels.forEach((text, l) => {
        if (key.labels.length < 12 || l % Math.ceil(key.labels.length / 10) === 0) shape(drawing, 'text', { x: x + 4, y: y(key, l) + 4, class: 'soft' }, text.slice(0, 14));
      });
      else {
        shape(drawing, 'text', { x: x + 4, y: top + 4, class: 'soft' }, formatNumber(key.high));
        shape(drawing, 'text', { x: x + 4, y: top + height + 4, class: 'soft' }, formatNumber(key.low));
      }
    });
    parent.append(element('p', 'note', `Blue runs survived, red ones did not.${data.lines.length < data.survival.count ? ` ${data.lines.length} of ${data.survival.count} runs are drawn.` : ''}`));
  }

  function showDistributions() {
    const parent = find('#distributions'), grid = element('div', 'histograms');
    for (const f of telling) {
      const { low, high, median, survived, failed, missing } = data.histograms[f];
      const box = element('figure');
      box.append(element('figcaption', '', label(data.figures[f]) + (missing ? ` (${missing} runs without a number)` : '')));
      const width = 230, height = 70, w = width / survived.length;
      const drawing = svg(box, width, height + 29);
      const most = Math.max(...survived.map((count, i) => count + failed[i]));
      survived.forEach((count, i) => {
        const a = (height * count) / most, b = (height * failed[i]) / most;
        if (a) shape(drawing, 'rect', { x: w * i, y: height - a, width: w - 0.5, height: a, class: 'good' });
        if (b) shape(drawing, 'rect', { x: w * i, y: height - a - b, width: w - 0.5, height: b, class: 'bad' });
      });
      shape(drawing, 'text', { x: 0, y: height + 13 }, formatNumber(low));
      shape(drawing, 'text', { x: width / 2, y: height + 25, 'text-anchor': 'middle', class: 'soft' }, `median ${formatNumber(median)}`);
      shape(drawing, 'text', { x: width, y: height + 13, 'text-anchor': 'end' }, formatNumber(high));
      grid.append(box);
    }
    parent.append(grid);
    if (!telling.length) parent.hidden = true;
  }

  showHeader();
  showSurvival();
  showMap();
  showLimits();
  showMatters();
  showCauses();
  showPicks();
  showLines();
  showScatter();
  showDistributions();
  find('#theme').onclick = Theme.toggle;
  // The cards with one drawing, which can be saved: [title, card].
  const drawn = [...document.querySelectorAll('.card')].filter((card) => card.querySelectorAll('svg').length === 1)
    .map((card) => [card.querySelector('h2').firstChild.textContent.trim(), card]);
  for (const [title, card] of drawn) card.querySelector('h2').append(button('SVG', 'save as a vector picture', () => saveSvg(card.querySelector('svg'), title)));
  const pictures = () => drawn.map(([title, card]) => [title, svgText(card.querySelector('svg'))]);
  window.tenonCampaign = { ready: true, data, pictures };
})();
