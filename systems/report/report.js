// The page of runs: header, transport, and the time that plots and replay share.
//
// A program can control the page through window.tenonReport: ready (everything is drawn), duration(), time(), seek(t) [s],
// play(), pause(), playing(), show(index of a drawn run), `webgl` (whether there is a replay), replay (a Replay, or null),
// plots (the Plots), pictures(width, height) (a [name, text of an SVG file] for each plot), picture(t) (that of the replay),
// movie(options) (a Movie), runs (the Recordings), append(run, samples) (see Recording.append; also draws the samples), live (a
// Live, or null), follower (the Follower of a live run).

'use strict';

// live: the Live of a live run, or null; bar: its RunBar.
function showReport(report, runs, live, bar) {
  const find = (selector) => document.querySelector(selector);

  function showHeader() {
    document.title = report.title;
    find('h1').textContent = report.title;
    find('#headline p').textContent = report.description;
    find('header').classList.toggle('several', runs.length > 1);
    for (const run of runs) {
      if (!run.verdict && runs.length === 1) continue;
      const text = (runs.length > 1 ? run.name + (run.verdict ? ': ' : '') : '') + run.verdict;
      const kind = run.good === null ? '' : run.good ? 'good' : 'bad';
      find('#verdicts').append(element(runs.length > 1 ? 'label' : 'span', `verdict ${kind}`, text));
    }
  }

  showHeader();
  showFigures(find('#figures'), runs);
  // The replay and its controls fill the part of the window below the header.
  const fit = () => document.documentElement.style.setProperty('--top', `${find('main').offsetTop}px`);
  fit();
  new ResizeObserver(fit).observe(find('header'));

  let time = 0, playing = false, last = 0;
  const drawn = runs.filter((run) => run.frames.shapes.length > 0 && run.frames.length > 0);
  const plots = new Plots(find('#plots'), runs, report.plots, {seek, edit: (plot) => picker.open(plot)});
  const picker = new Picker(find('#picker'), runs, plots, (names, target) => {
    if (target instanceof Plot) return plots.extend(target, names);
    const specs = target === 'apart' ? names.map((name) => [name]) : [names];
    let plot = null;
    for (const signals of specs) {
      const title = signals.length > 2 ? `${signals[0]} and ${signals.length - 1} more` : signals.join(', ');
      plot = plots.add({title, signals, group: 'chosen signals'});
    }
    plot.box.scrollIntoView({block: 'nearest'});
    layOut();
  });
  let replay = null;
  if (drawn.length > 0) {
    try {
      replay = new Replay(find('#stage'), drawn, live && {travels: !!live.controls.drive || /person/.test((live.controls.goal || {}).name)});
    } catch (error) {
      if (error.message !== 'no WebGL') throw error;
      find('#no-webgl').hidden = false;
    }
  }
  const api = window.tenonReport = {
    ready: false, webgl: !!replay, replay, plots, runs, duration: () => plots.duration,
    time: () => time, playing: () => playing, seek, play: () => setPlaying(true), pause: () => setPlaying(false),
    show, append, live, follower: null,
    pictures: (width, height) => plots.plots.map((plot) => [plot.name, pictureOf(plot, width, height)])
        .filter(([, picture]) => picture).map(([name, picture]) => [name, svgText(picture)]),
    movie: (options) => new Movie(replay, {from: 0, to: plots.duration, ...options}),
    picture(t) {
      seek(t);
      return svgText(pictureOfReplay(replay, report.title, time));
    },
  };

  // Without a replay the plots get the full width.
  let hideReplay = false;
  function layOut() {
    const main = find('main');
    main.classList.toggle('wide', !replay || hideReplay);
    main.classList.toggle('figures-only', !replay && plots.plots.length === 0);
    find('#stage').hidden = !replay || hideReplay;
    find('#hide-replay').hidden = !replay;
    find('#hide-replay').setAttribute('aria-pressed', String(hideReplay));
    find('#tools').hidden = runs.every((run) => run.signals.size === 0);
  }

  function append(run, samples) {
    runs[run].append(samples);
    plots.refresh();
    if (replay) replay.refresh();
    find('#scrub').max = plots.duration;
    place(time);
  }

  function clock(t) {
    time = t;
    find('#scrub').value = time;
    find('#clock').textContent = find('#now').textContent = `${time.toFixed(plots.duration < 10 ? 3 : 2)} s`;
  }
  function place(t) {
    clock(Math.min(Math.max(t, live ? live.run.start : 0), plots.duration));
    plots.setTime(time);
    if (replay) replay.setTime(time);
  }
  // Shows the time t; in a live run the page stops following the newest samples.
  function seek(t) {
    if (api.follower) api.follower.leave();
    place(t);
  }

  function setPlaying(on) {
    playing = on;
    find('#play').textContent = on ? '❚❚' : '▶';
    if (!on) return;
    if (time >= plots.duration) seek(0);
    last = performance.now();
    requestAnimationFrame(step);
  }

  function step(now) {
    if (!playing) return;
    seek(time + Math.max(0, now - last) / 1000 * Number(find('#speed').value));
    last = now;
    if (time >= plots.duration) {
      setPlaying(false);
      if (api.follower) api.follower.join();
      return;
    }
    requestAnimationFrame(step);
  }

  function show(index) {
    if (!replay) return;
    replay.shown = index;
    replay.followed = null;
    find('#variant').value = index;
    place(time);
  }

  function addLegend() {
    if (!replay) return;
    for (const role of replay.roles) {
      const entry = button('', 'show or hide', () => {
        if (!replay.hiddenRoles.delete(role)) replay.hiddenRoles.add(role);
        show();
        place(time);
      });
      const show = () => entry.setAttribute('aria-pressed', String(!entry.classList.toggle('off', replay.hiddenRoles.has(role))));
      const swatch = element('span', 'swatch');
      swatch.style.background = replay.colorOf(role) || 'linear-gradient(90deg, #3b528b, #21918c, #fdc825)';
      entry.append(swatch, document.createTextNode(role));
      entry.setAttribute('aria-label', `show ${role}`);
      show();
      find('#legend').append(entry);
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

  // The menu that saves the replay: the frame that is shown, or a video of the time window of the plots at the selected speed.
  function addSaving() {
    const menu = find('#save'), stop = find('#stop'), {title} = report;
    if (!replay) return;
    async function film(scale, options, work) {
      const {width, height} = replay.size, movie = api.movie({width: scale * width, height: scale * height, ...options});
      try {
        return await work(movie);
      } finally {
        movie.end();
        place(time);
      }
    }
    async function video(movie) {
      let on = true;
      setPlaying(false);
      menu.hidden = !(stop.hidden = false);
      stop.onclick = () => on = false;
      try {
        for (let i = 0; i < movie.count && on; ++i) {
          stop.textContent = `stop at ${Math.round(100 * i / movie.count)} %`;
          await movie.add(i);
        }
        if (on) saveFile(await movie.file(), title, 'webm');
      } finally {
        menu.hidden = !(stop.hidden = true);
      }
    }
    const savings = [
      ['save …'],
      ['picture (SVG)', () => saveSvg(pictureOfReplay(replay, title, time), title)],
      ['picture (PNG)', () => film(2, {}, async (movie) => saveFile(await movie.png(time), title, 'png'))],
    ];
    if (window.VideoEncoder && !live) {
      const span = () => ({from: Math.max(plots.window[0], 0), to: Math.min(plots.window[1], plots.duration), speed: Number(find('#speed').value)});
      savings.push(['video (WebM)', () => film(1, span(), video)]);
    }
    for (const [name] of savings) menu.append(element('option', '', name));
    menu.onchange = () => {
      const [, save] = savings[menu.selectedIndex];
      menu.selectedIndex = 0;
      save();
    };
  }

  function addTransport() {
    find('#scrub').max = plots.duration;
    find('#scrub').oninput = (event) => seek(Number(event.target.value));
    find('#play').onclick = () => setPlaying(!playing);
    for (const speed of [0.1, 0.25, 0.5, 1, 2, 5, 10]) {
      const option = element('option', '', `${speed}×`);
      option.value = speed;
      option.selected = speed === 1;
      find('#speed').append(option);
    }
    find('#follow-label').hidden = find('#reset-view').hidden = !replay;
    find('#follow').onchange = (event) => replay.setFollow(event.target.checked);
    find('#reset-view').onclick = () => {
      find('#follow').checked = replay.travels;
      replay.setFollow(replay.travels);
      replay.resetView();
    };
    if (replay) find('#reset-view').onclick();
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
      place(time);
    };
    document.querySelectorAll('.verdict').forEach((chip, r) => {
      const box = element('input');
      box.type = 'checkbox';
      box.checked = true;
      box.title = 'show in the plots';
      box.onchange = () => plots.setVisible(r, box.checked);
      chip.prepend(box);
    });
  }

  function addTools() {
    let folded = false;
    find('#pick').onclick = () => picker.open(null);
    find('#fold-all').onclick = () => {
      folded = !folded;
      plots.foldAll(folded);
      find('#fold-all').textContent = folded ? 'unfold all' : 'fold all';
    };
    find('#zoom-out').onclick = () => api.follower ? api.follower.leave(true) : plots.zoomOut();
    find('#columns').onchange = (event) => plots.setColumns(event.target.value);
    find('#hide-replay').onclick = () => {
      hideReplay = !hideReplay;
      layOut();
    };
    find('#theme').onclick = Theme.toggle;
    find('#help-button').onclick = () => find('#help').showModal();

    const splitter = find('#splitter');
    let share = 54;
    const set = (percent) => {
      share = Math.min(Math.max(percent, 20), 80);
      find('main').style.setProperty('--split', `${share}fr`);
      find('main').style.setProperty('--rest', `${100 - share}fr`);
      splitter.setAttribute('aria-valuenow', String(Math.round(share)));
    };
    set(share);
    splitter.onpointerdown = (down) => {
      splitter.setPointerCapture(down.pointerId);
      splitter.onpointermove = (move) => {
        const box = find('main').getBoundingClientRect();
        set(100 * (move.clientX - box.left) / box.width);
      };
    };
    splitter.onpointerup = () => splitter.onpointermove = null;
    splitter.onkeydown = (event) => {
      const step = {ArrowRight: 3, ArrowLeft: -3}[event.key];
      if (!step) return;
      set(share + step);
      event.preventDefault();
      event.stopPropagation();
    };
  }

  // Goes to the next event after or before the current time.
  function toEvent(direction) {
    const times = plots.events().map((event) => event.time).filter((t) => direction * (t - time) > 1e-9);
    if (times.length) seek(direction > 0 ? Math.min(...times) : Math.max(...times));
  }
  function changeSpeed(step) {
    const select = find('#speed');
    select.selectedIndex = Math.min(Math.max(select.selectedIndex + step, 0), select.options.length - 1);
  }
  const click = (selector) => () => {
    const node = find(selector);
    if (!node.hidden && !node.closest('[hidden]')) node.click();
  };
  const move = (step) => () => seek(time + step);

  // Adds the panels of a live run, dragging in the replay, and keys that take precedence over those of a report.
  function goLive() {
    const follower = api.follower = bar.follower = new Follower(live, {plots, replay, clock, stop: () => setPlaying(false)});
    const drives = (act) => () => live.drives && act();
    new Tune(live, find('#side'));
    const drive = api.drive = new Drive(live, find('#side'));
    if (replay) api.grab = new Grab(live, replay, follower, drive.goal);
    const keys = drive.velocity ? [
      ...['w', '↑', 's', '↓'].map((label) => ({label, help: 'drive forward or back; faster with shift'})),
      ...['a', '←', 'd', '→'].map((label) => ({label, help: 'drive to the left or to the right'})),
      ...['q', 'e'].map((label) => ({label, help: 'turn to the left or to the right'})),
    ] : [];
    return [
      ...keys,
      {key: ' ', label: 'space', help: 'pause or resume the run; in the past: play', act: () => follower.on ? drives(() => bar.togglePause())() : setPlaying(!playing)},
      {key: '.', label: '.', help: 'advance the paused run by one tick', act: drives(() => bar.tick.click())},
      {key: 'b', label: 'b', help: 'set the run back by 5 s', act: drives(() => bar.back.click())},
      {key: '[', label: '[', help: 'slow down or speed up the run', act: drives(() => bar.changeRate(-1))},
      {key: ']', label: ']', help: 'slow down or speed up the run', act: drives(() => bar.changeRate(1))},
      {key: 'l', label: 'l', help: 'follow the newest samples', act: () => follower.join()},
      {key: 'End', label: 'end', help: 'follow the newest samples', act: () => follower.join()},
      {key: '+', label: '+', help: 'add signals', act: click('#pick')},
    ];
  }

  layOut();
  addLegend();
  addTransport();
  addSaving();
  addTools();
  place(live ? plots.duration : 0);
  const liveKeys = live ? goLive() : [];
  // Whether a live run uses the key to drive the robot, or for another purpose than a report does.
  const taken = (key) => liveKeys.some((own) => own.key === key) || (api.drive && api.drive.velocity && DRIVE_KEYS[key]);
  addKeys(find('#help'), [...liveKeys, ...[
    {key: ' ', label: 'space', help: 'play or pause', act: () => setPlaying(!playing)},
    {key: 'ArrowLeft', shift: false, label: '←', help: 'one frame back or forward (20 ms)', act: move(-0.02)},
    {key: 'ArrowRight', shift: false, label: '→', help: 'one frame back or forward (20 ms)', act: move(0.02)},
    {key: 'ArrowLeft', shift: true, label: 'shift ←', help: 'one second back or forward', act: move(-1)},
    {key: 'ArrowRight', shift: true, label: 'shift →', help: 'one second back or forward', act: move(1)},
    {key: 'Home', label: 'home', help: 'go to the start or the end', act: () => seek(0)},
    {key: 'End', label: 'end', help: 'go to the start or the end', act: () => seek(plots.duration)},
    {key: 'p', label: 'p', help: 'go to the previous or the next event', act: () => toEvent(-1)},
    {key: 'n', label: 'n', help: 'go to the previous or the next event', act: () => toEvent(1)},
    {key: '[', label: '[', help: 'play slower or faster', act: () => changeSpeed(-1)},
    {key: ']', label: ']', help: 'play slower or faster', act: () => changeSpeed(1)},
    {key: 'f', label: 'f', help: 'follow the body', act: click('#follow')},
    {key: 'r', label: 'r', help: 'reset the view of the replay', act: click('#reset-view')},
    {key: 'v', label: 'v', help: 'show the next run in the replay', act: () => replay && show((replay.shown + 1) % drawn.length)},
    {key: 'g', label: 'g', help: 'show the other runs as ghosts', act: click('#ghosts')},
    {key: 'h', label: 'h', help: 'hide or show the replay', act: click('#hide-replay')},
    {key: 'a', label: 'a', help: 'add signals', act: click('#pick')},
    {key: 'z', label: 'z', help: 'show the whole run in the plots', act: click('#zoom-out')},
    {key: 't', label: 't', help: 'light or dark', act: Theme.toggle},
    {key: '?', label: '?', help: 'show this list', act: () => find('#help').showModal()},
  ].filter(({key}) => !taken(key))]);
  api.ready = true;
}

(() => {
  const report = JSON.parse(document.getElementById('data').textContent);
  if (!report.live) return showReport(report, report.runs.map(Recording.read), null);
  document.title = document.querySelector('h1').textContent = report.title;
  const live = new Live(report, (shown, runs) => showReport(shown, runs, live, bar));
  const bar = new RunBar(live);
  document.querySelector('header').after(bar.box);
})();
