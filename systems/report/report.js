// The page: table of figures, transport, and the one time that plots and replay share.
//
// window.tenonReport lets a program drive the page: ready (everything is drawn), duration [s], time(), seek(t),
// play(), pause(), playing(), show(index of a drawn variant), webgl (whether there is a replay), replay (a Replay, or null).

(() => {
  const report = JSON.parse(document.getElementById('data').textContent);
  const runs = report.runs;
  const find = (selector) => document.querySelector(selector);

  function showHeader() {
    document.title = report.title;
    find('h1').textContent = report.title;
    find('#headline p').textContent = report.description;
    for (const run of runs) {
      if (!run.verdict && runs.length === 1) continue;
      const text = (runs.length > 1 ? run.name + (run.verdict ? ': ' : '') : '') + run.verdict;
      find('#verdicts').append(element('span', `verdict ${run.good === null ? '' : run.good ? 'good' : 'bad'}`, text));
    }
  }

  function showFigures() {
    const keys = [...new Set(runs.flatMap((run) => run.figures.map(([key]) => key)))];
    const parent = find('#figures');
    parent.hidden = keys.length === 0;
    const tables = Math.max(1, Math.min(keys.length, runs.length === 1 ? 4 : runs.length < 4 ? 2 : 1));
    const length = Math.ceil(keys.length / tables);
    for (let begin = 0; begin < keys.length; begin += length) {
      const table = element('table');
      if (runs.length > 1) {
        const head = table.createTHead().insertRow();
        head.append(element('th'));
        runs.forEach((run, r) => {
          const cell = element('th');
          const swatch = element('span', 'swatch');
          swatch.style.background = RUN_COLORS[r % RUN_COLORS.length];
          cell.append(swatch, document.createTextNode(run.name));
          head.append(cell);
        });
        head.append(element('th'));
      }
      const body = table.createTBody();
      for (const key of keys.slice(begin, begin + length)) {
        const row = body.insertRow();
        const [label, unit] = splitUnit(key);
        const head = element('th', '', label);
        head.title = key;
        row.append(head);
        for (const run of runs) {
          const figure = run.figures.find(([name]) => name === key);
          const value = figure ? figure[1] : null;
          const text = value === null ? '–' : typeof value === 'number' ? formatNumber(value) : String(value);
          row.append(element('td', typeof value === 'string' ? 'text' : '', text));
        }
        row.append(element('td', 'unit', unit));
      }
      parent.append(table);
    }
  }

  showHeader();
  showFigures();
  // The replay and its controls fill what the header leaves of the window.
  document.documentElement.style.setProperty('--top', `${find('main').offsetTop}px`);

  for (const run of runs) {
    run.frames = run.frames && run.frames.shapes.length > 0 ? new Frames(run.frames) : null;
  }
  const drawn = runs.filter((run) => run.frames);
  const ends = runs.flatMap((run) => [
    ...(run.events || []).map((event) => event.time),
    ...(run.frames ? [run.frames.time[run.frames.time.length - 1]] : []),
    ...run.plots.map((plot) => decode(plot.time, Float64Array)).map((time) => time[time.length - 1] || 0),
  ]);
  const duration = Math.max(1e-6, ...ends);

  let time = 0, playing = false, last = 0;
  const api = window.tenonReport = {
    ready: false, duration, webgl: false, replay: null,
    time: () => time, playing: () => playing, seek, play: () => setPlaying(true), pause: () => setPlaying(false),
    show,
  };

  const plots = new Plots(find('#plots'), runs, duration, seek);
  let replay = null;
  if (drawn.length > 0) {
    try {
      replay = new Replay(find('#stage'), drawn);
      api.webgl = true;
      api.replay = replay;
    } catch (error) {
      if (error.message !== 'no WebGL') throw error;
      find('#no-webgl').hidden = false;
    }
  }
  find('#stage').hidden = drawn.length === 0;
  find('main').classList.toggle('no-plots', plots.plots.length === 0);

  function seek(t) {
    time = Math.min(Math.max(t, 0), duration);
    find('#scrub').value = time;
    find('#clock').textContent = `${time.toFixed(duration < 10 ? 3 : 2)} s`;
    plots.setTime(time);
    if (replay) replay.setTime(time);
  }

  function setPlaying(on) {
    playing = on;
    find('#play').textContent = on ? '❚❚' : '▶';
    if (!on) return;
    if (time >= duration) seek(0);
    last = performance.now();
    requestAnimationFrame(step);
  }

  function step(now) {
    if (!playing) return;
    seek(time + Math.max(0, now - last) / 1000 * Number(find('#speed').value));
    last = now;
    if (time >= duration) return setPlaying(false);
    requestAnimationFrame(step);
  }

  function show(index) {
    if (!replay) return;
    replay.shown = index;
    replay.followed = null;
    find('#variant').value = index;
    seek(time);
  }

  function addLegend() {
    if (!replay) return;
    for (const role of replay.roles) {
      const button = element('button');
      const swatch = element('span', 'swatch');
      const colored = replay.runs.some((run) => run.actors.some((a) => a.shape.role === role && a.range));
      swatch.style.background = colored ? 'linear-gradient(90deg, #3b528b, #21918c, #fdc825)' :
          '#' + new THREE.Color(ROLE_COLORS[role] || 0x888888).getHexString();
      button.append(swatch, document.createTextNode(role));
      button.title = 'show or hide';
      button.onclick = () => {
        if (!replay.hiddenRoles.delete(role)) replay.hiddenRoles.add(role);
        button.classList.toggle('off', replay.hiddenRoles.has(role));
        seek(time);
      };
      find('#legend').append(button);
    }
    const [unit, range] = Object.entries(replay.ranges)[0] || [];
    if (!unit) return;
    const bar = find('#colorbar');
    bar.hidden = false;
    bar.firstElementChild.textContent = `${formatNumber(range[0])}`;
    bar.lastElementChild.textContent = `${formatNumber(range[1])} ${unit}`;
    bar.querySelector('i').style.background =
        `linear-gradient(90deg, ${SCALE.map((c) => `rgb(${c.join(',')})`).join(', ')})`;
  }

  function addTransport() {
    find('#scrub').max = duration;
    find('#scrub').oninput = (event) => seek(Number(event.target.value));
    find('#play').onclick = () => setPlaying(!playing);
    for (const speed of [0.1, 0.25, 0.5, 1, 2, 5, 10]) {
      const option = element('option', '', `${speed}×`);
      option.value = speed;
      option.selected = speed === 1;
      find('#speed').append(option);
    }
    for (const selector of ['#follow', '#reset-view']) find(selector).disabled = !replay;
    find('#follow').onchange = (event) => replay.setFollow(event.target.checked);
    find('#reset-view').onclick = () => {
      find('#follow').checked = replay.travels;
      replay.setFollow(replay.travels);
      replay.resetView();
    };
    if (replay) find('#reset-view').onclick();
    document.addEventListener('keydown', (event) => {
      if (/^(INPUT|SELECT|BUTTON)$/.test(event.target.tagName) && event.target.id !== 'scrub') return;
      if (event.key === ' ') setPlaying(!playing);
      else if (event.key === 'ArrowRight' || event.key === 'ArrowLeft') {
        seek(time + (event.key === 'ArrowRight' ? 1 : -1) * (event.shiftKey ? 1 : 0.05));
      } else return;
      event.preventDefault();
    });
    if (runs.length < 2) return;

    find('#variant').hidden = find('#ghosts-label').hidden = drawn.length < 2 || !replay;
    drawn.forEach((run, i) => {
      const option = element('option', '', run.name);
      option.value = i;
      find('#variant').append(option);
    });
    find('#variant').onchange = (event) => show(Number(event.target.value));
    find('#ghosts').onchange = (event) => {
      replay.ghosts = event.target.checked;
      seek(time);
    };
    [...document.querySelectorAll('.verdict')].forEach((chip, r) => {
      const box = element('input');
      box.type = 'checkbox';
      box.checked = true;
      box.title = 'show in the plots';
      box.onchange = () => plots.setVisible(r, box.checked);
      chip.prepend(box);
    });
  }

  addLegend();
  addTransport();
  seek(0);
  api.ready = true;
})();
