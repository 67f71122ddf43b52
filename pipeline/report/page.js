'use strict';
// The preview page. All pictures are data URIs in the JSON of #data; nothing is fetched.
//   eyes.views[row * columns + column]: row 0 is the highest eye, column 0 the left-most.

const data = JSON.parse(document.getElementById('data').textContent);
const eyes = data.eyes;
const byId = (id) => document.getElementById(id);

function element(tag, properties, ...children) {
  const node = Object.assign(document.createElement(tag), properties || {});
  node.append(...children);
  return node;
}
// An eye's PSNR has no number where the pictures are equal or nothing of them was seen.
const decibels = (view) => (view.psnr_db !== null ? view.psnr_db.toFixed(1) : view.equal ? 'equal' : 'unseen');
const similarity = (view) => (view.ssim === null ? '\u2013' : view.ssim.toFixed(3));
const percent = (share) => (100 * share).toFixed(1) + ' %';
const millimetres = (value) => (Math.abs(value) < 0.05 ? '0.0' : (value > 0 ? '+' : '\u2212') + Math.abs(value).toFixed(1));

// ---- The eye's picture ----

const canvas = byId('eye');
const paint = canvas.getContext('2d', {willReadFrequently: true});
const last = {column: eyes.x_mm.length - 1, row: eyes.y_mm.length - 1};
// The eye in units of positions; fractions lie between the simulated positions.
const eye = {column: last.column / 2, row: last.row / 2, mode: 'simulated', blend: false};
const decoded = new Map();  // data URI -> Image

const labels = {
  simulated: 'Simulated display: prefilter + display response + pinhole eye.',
  target: 'Target: the capture rendered directly at this eye position, without a display.',
  difference: 'Difference of the two in sRGB codes, amplified 4\u00d7: black is equal.',
};

function picture(uri) {
  if (!decoded.has(uri)) {
    const image = new Image();
    image.src = uri;
    decoded.set(uri, image.decode().then(() => image));
  }
  return decoded.get(uri);
}

// The simulated positions that show now, with weights: the nearest one, or the four around.
function shownPositions() {
  if (!eye.blend) return [{column: Math.round(eye.column), row: Math.round(eye.row), weight: 1}];
  const shown = [];
  const c = Math.min(Math.floor(eye.column), Math.max(0, last.column - 1));
  const r = Math.min(Math.floor(eye.row), Math.max(0, last.row - 1));
  for (const [dc, dr] of [[0, 0], [1, 0], [0, 1], [1, 1]]) {
    const wc = dc ? eye.column - c : 1 - (eye.column - c);
    const wr = dr ? eye.row - r : 1 - (eye.row - r);
    if (wc * wr > 1e-3) shown.push({column: c + dc, row: r + dr, weight: wc * wr});
  }
  return shown;
}
const viewAt = (position) => eyes.views[position.row * eyes.x_mm.length + position.column];

async function layerOf(kind, positions) {
  const images = await Promise.all(positions.map((p) => picture(viewAt(p)[kind])));
  return () => {
    paint.globalCompositeOperation = 'lighter';
    images.forEach((image, i) => {
      paint.globalAlpha = positions[i].weight;
      paint.drawImage(image, 0, 0, canvas.width, canvas.height);
    });
    paint.globalAlpha = 1;
    paint.globalCompositeOperation = 'source-over';
  };
}

function clear() {
  paint.fillStyle = '#000';
  paint.fillRect(0, 0, canvas.width, canvas.height);
}

function paintDifference(drawSimulated, drawTarget) {
  clear();
  drawTarget();
  const target = paint.getImageData(0, 0, canvas.width, canvas.height).data;
  clear();
  drawSimulated();
  const pixels = paint.getImageData(0, 0, canvas.width, canvas.height);
  for (let i = 0; i < target.length; i += 4) {
    for (let c = 0; c < 3; ++c) pixels.data[i + c] = 4 * Math.abs(pixels.data[i + c] - target[i + c]);
  }
  paint.putImageData(pixels, 0, 0);
}

let request = 0;
async function draw() {
  const mine = ++request;
  const positions = shownPositions();
  const simulated = eye.mode === 'target' ? null : await layerOf('simulated', positions);
  const target = eye.mode === 'simulated' ? null : await layerOf('target', positions);
  if (mine !== request) return;  // the eye has moved on
  if (simulated && target) {
    paintDifference(simulated, target);
  } else {
    clear();
    (simulated || target)();
  }
  describe(positions);
}

function describe(positions) {
  const nearest = {column: Math.round(eye.column), row: Math.round(eye.row)};
  const view = viewAt(nearest);
  const x = eyes.x_mm[nearest.column], y = eyes.y_mm[nearest.row];
  canvas.dataset.column = nearest.column;
  canvas.dataset.row = nearest.row;
  canvas.dataset.mode = eye.mode;
  canvas.dataset.positions = positions.length;
  byId('label').textContent = labels[eye.mode] + (positions.length > 1 ? ' Cross-faded between positions.' : '');
  canvas.setAttribute('aria-label', `${eye.mode} picture, eye ${millimetres(x)} mm right, ${millimetres(y)} mm up`);
  const rows = [
    ['Right', millimetres(x) + ' mm'], ['Up', millimetres(y) + ' mm'], ['Distance', eyes.distance_mm.toFixed(0) + ' mm'],
    ['PSNR, dB (sRGB)', decibels(view)], ['SSIM', similarity(view)],
    ['Display light known', percent(view.known)], ['Capture saw', percent(view.seen)],
  ];
  byId('readout').replaceChildren(...rows.flatMap(([name, value]) => [
    element('dt', {textContent: name}), element('dd', {textContent: value})]));
  drawHere();
  for (const cell of document.querySelectorAll('#metrics td[data-column]')) {
    cell.classList.toggle('here', +cell.dataset.column === nearest.column && +cell.dataset.row === nearest.row);
  }
}

function moveTo(column, row) {
  eye.column = Math.min(last.column, Math.max(0, column));
  eye.row = Math.min(last.row, Math.max(0, row));
  draw();
}

function listenToCanvas() {
  let from = null;
  canvas.addEventListener('pointerdown', (event) => {
    from = {x: event.clientX, y: event.clientY, column: eye.column, row: eye.row};
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add('dragging');
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!from) return;
    // Across the whole picture = across all positions. Right is to the right, up is up (row 0 on top).
    const box = canvas.getBoundingClientRect();
    moveTo(from.column + (event.clientX - from.x) / box.width * last.column,
           from.row + (event.clientY - from.y) / box.height * last.row);
  });
  const end = () => { from = null; canvas.classList.remove('dragging'); };
  canvas.addEventListener('pointerup', end);
  canvas.addEventListener('pointercancel', end);
  const steps = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
  canvas.addEventListener('keydown', (event) => {
    const step = steps[event.key];
    if (event.key === 'Home') moveTo(last.column / 2, last.row / 2);
    else if (step) moveTo(Math.round(eye.column) + step[0], Math.round(eye.row) + step[1]);
    else return;
    event.preventDefault();
  });
}

// ---- The map of positions: 100 units across ----

const map = byId('map');
const span = Math.max(1e-9, ...eyes.x_mm.map(Math.abs), ...eyes.y_mm.map(Math.abs), eyes.clean_box_mm || 0);
const mapX = (mm) => 50 + 44 * mm / span;
const mapY = (mm) => 50 - 44 * mm / span;

function svg(tag, attributes) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  return node;
}

function drawMap() {
  map.setAttribute('viewBox', '0 0 100 100');
  map.append(svg('rect', {class: 'frame', x: 0.5, y: 0.5, width: 99, height: 99, rx: 3}));
  if (eyes.clean_box_mm > 0) {
    map.append(svg('rect', {class: 'box', x: mapX(-eyes.clean_box_mm), y: mapY(eyes.clean_box_mm),
      width: 88 * eyes.clean_box_mm / span, height: 88 * eyes.clean_box_mm / span}));
    byId('map-note').textContent = `Dashed: clean eye box, \u00b1${eyes.clean_box_mm.toFixed(0)} mm. Eyes beyond it ` +
      `see ${eyes.beyond_box}; that is simulated, too.`;
  }
  for (const y of eyes.y_mm) for (const x of eyes.x_mm) map.append(svg('circle', {class: 'dot', cx: mapX(x), cy: mapY(y), r: 1.2}));
  map.append(svg('circle', {class: 'here', r: 3.2, cx: 50, cy: 50}));
  const go = (event) => {
    const box = map.getBoundingClientRect();
    const at = (fraction, positions, sign) => {  // inverse of mapX, mapY in units of positions
      const mm = sign * (100 * fraction - 50) / 44 * span, first = positions[0], end = positions[positions.length - 1];
      return end === first ? 0 : (mm - first) / (end - first) * (positions.length - 1);
    };
    moveTo(at((event.clientX - box.left) / box.width, eyes.x_mm, 1), at((event.clientY - box.top) / box.height, eyes.y_mm, -1));
  };
  map.addEventListener('pointerdown', (event) => { map.setPointerCapture(event.pointerId); go(event); });
  map.addEventListener('pointermove', (event) => { if (event.buttons) go(event); });
}

function drawHere() {
  const between = (positions, at) => {
    const i = Math.floor(at), next = Math.min(i + 1, positions.length - 1);
    return positions[i] + (at - i) * (positions[next] - positions[i]);
  };
  const here = map.querySelector('.here');
  const column = eye.blend ? eye.column : Math.round(eye.column), row = eye.blend ? eye.row : Math.round(eye.row);
  here.setAttribute('cx', mapX(between(eyes.x_mm, column)));
  here.setAttribute('cy', mapY(between(eyes.y_mm, row)));
}

// ---- The eye in the middle focuses ----

function showPlane(index) {
  const plane = data.focus.planes[index], at = millimetres(plane.plane_mm) + ' mm';
  byId('plane-text').textContent = `${at}: ${decibels(plane)} dB, SSIM ${similarity(plane)}`;
  for (const kind of ['simulated', 'target']) {
    byId('focus-' + kind).src = plane[kind];
    byId('focus-' + kind).alt = `${kind} picture, focused on ${at}`;
  }
}

function showFocus() {
  const planes = data.focus.planes;
  if (!planes.length) return;
  byId('focus').hidden = false;
  byId('focus-note').textContent = `Through a pupil of ${data.focus.pupil_mm} mm in the middle of the eye box: what lies in ` +
    'the plane in focus is sharp, things before and behind it are blurred. Millimetres to the front of the display\u2019s middle.';
  const slider = byId('plane');
  slider.max = planes.length - 1;
  slider.value = Math.floor(planes.length / 2);
  slider.addEventListener('input', () => showPlane(+slider.value));
  showPlane(+slider.value);
}

// ---- Capture, depth, layers ----

function showView(index) {
  const view = data.depth.views[index];
  byId('photo').src = view.photo;
  byId('photo').alt = `Photograph ${view.name}`;
  byId('photo-caption').textContent = `Photograph ${view.name}` + (view.reference ? ', the reference view of the placement' : '');
  byId('depth').src = view.depth;
  byId('depth').alt = `Depth of ${view.name}, colour-coded`;
  byId('depth-caption').textContent = `Depth of ${view.name}: ${percent(view.known)} of its pixels known`;
  document.querySelectorAll('#view-choice button').forEach((b, i) => b.setAttribute('aria-pressed', i === index));
}

function showCapture() {
  const depth = data.depth;
  byId('view-choice').append(...depth.views.map((view, i) =>
    element('button', {type: 'button', textContent: view.name, onclick: () => showView(i)})));
  const strip = element('div', {className: 'strip'});
  strip.style.background = `linear-gradient(to right, ${depth.colors.join(',')})`;
  const ticks = element('div', {className: 'ticks'});
  for (const tick of depth.ticks) {
    const mark = element('span', {textContent: tick.text});
    mark.style.left = 100 * tick.at + '%';
    ticks.append(mark);
  }
  byId('scale').append(strip, ticks,
    element('p', {className: 'muted'}, element('span', {className: 'unknown'}), 'unknown depth. ' + depth.note));
  showView(Math.max(0, depth.views.findIndex((v) => v.reference)));
}

function showLayers() {
  byId('layers').append(...data.layers.map((layer, i) => element('figure', {},
    element('img', {id: 'layer-' + i, src: layer.mean, alt: `Layer ${i}, mean of its slots`}),
    element('figcaption', {textContent: layer.caption}))));
}

// ---- Through the layers and their slots ----

const steps = data.steps;
const step = {layer: 0, slot: 0};

// A picture of a panel, or of a part of it; the sizes are said first, so that nothing moves when it comes.
function panelPicture({picture: uri, caption, is_part: isPart}, part) {
  const size = isPart ? part : steps;
  const image = element('img', {src: uri, alt: caption});
  image.style.aspectRatio = `${size.width} / ${size.height}`;
  const figure = element('figure', {className: isPart ? 'part' : 'whole'}, element('div', {}, image),
    element('figcaption', {textContent: caption}));
  if (isPart) {
    image.style.width = `${part.width * Math.max(1, Math.floor(288 / part.width))}px`;  // pixels of one size
  } else {
    const mark = element('span', {className: 'mark'});
    mark.style.left = `${100 * part.x / steps.width}%`;
    mark.style.top = `${100 * part.y / steps.height}%`;
    mark.style.width = `${100 * part.width / steps.width}%`;
    mark.style.height = `${100 * part.height / steps.height}%`;
    figure.firstChild.append(mark);
  }
  return figure;
}

function stepTo(layer, slot) {
  step.layer = Math.min(steps.layers.length - 1, Math.max(0, layer));
  const {slots, part} = steps.layers[step.layer];
  step.slot = Math.min(slots.length - 1, Math.max(0, slot));
  const shown = slots[step.slot];
  byId('step-pictures').replaceChildren(...shown.pictures.map((picture) => panelPicture(picture, part)));
  for (const [name, at, count, text] of [['layer', step.layer, steps.layers.length, data.layers[step.layer].caption],
    ['slot', step.slot, slots.length, shown.name]]) {
    const slider = byId('step-' + name);
    slider.max = count - 1;
    slider.value = at;
    slider.disabled = count === 1;
    slider.setAttribute('aria-valuetext', text);
    byId(name + '-back').disabled = at === 0;
    byId(name + '-on').disabled = at === count - 1;
    byId(`step-${name}-text`).textContent = text;
  }
}

function showSteps() {
  if (!steps.layers.length) return;
  byId('steps').hidden = false;
  byId('step-note').textContent = steps.note;
  byId('step-help-slots').textContent = steps.slot_name + 's';
  byId('step-slot-name').textContent = steps.slot_name[0].toUpperCase() + steps.slot_name.slice(1);
  const by = (layers, slots) => stepTo(step.layer + layers, step.slot + slots);
  byId('step-layer').addEventListener('input', (event) => stepTo(+event.target.value, step.slot));
  byId('step-slot').addEventListener('input', (event) => stepTo(step.layer, +event.target.value));
  for (const [name, layers, slots] of [['layer', 1, 0], ['slot', 0, 1]]) {
    byId(name + '-back').addEventListener('click', () => by(-layers, -slots));
    byId(name + '-on').addEventListener('click', () => by(layers, slots));
  }
  byId('slot-back').setAttribute('aria-label', steps.slot_name + ' before');
  byId('slot-on').setAttribute('aria-label', steps.slot_name + ' after');
  const keys = {ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0]};
  byId('step-pictures').addEventListener('keydown', (event) => {
    if (!keys[event.key]) return;
    by(...keys[event.key]);
    event.preventDefault();
  });
  stepTo(0, 0);
}

// ---- Resolution over depth ----

function showCutoff() {
  if (!data.cutoff) return;
  byId('cutoff').hidden = false;
  byId('cutoff-figure').src = data.cutoff;
  byId('cutoff-figure').alt = 'Cut-off frequency over depth, and the scene\u2019s depths';
  byId('cutoff-caption').textContent = data.cutoff_text;
}

// ---- Numbers ----

function showFacts() {
  byId('facts').append(...data.facts.flatMap(([name, value]) => [
    element('dt', {textContent: name}), element('dd', {textContent: value})]));
  const head = element('tr', {}, ...['Stage', 'Seconds', 'Peak memory'].map((t) => element('th', {textContent: t, scope: 'col'})));
  byId('stages').append(head, ...data.stages.map((stage) => element('tr', {},
    element('td', {textContent: stage.stage}), element('td', {textContent: stage.seconds.toFixed(1)}),
    element('td', {textContent: stage.peak_memory_mib.toFixed(0) + ' MiB'}))));
  if (data.warnings.length) {
    byId('warnings').hidden = false;
    byId('warnings').querySelector('ul').append(...data.warnings.map((text) => element('li', {textContent: text})));
  }
}

// A cell's ground from red over amber to green between 24 and 42 dB, grey where nothing was seen; the text
// stays dark on it.
function ground(view) {
  if (view.psnr_db === null && !view.equal) return 'hsl(0 0% 78%)';
  const share = view.equal ? 1 : Math.min(1, Math.max(0, (view.psnr_db - 24) / 18));
  return `hsl(${Math.round(5 + 135 * share)} 60% 78%)`;
}

function showMetrics() {
  byId('metrics-note').textContent = data.metrics.note;
  const table = byId('metrics');
  table.append(element('caption', {textContent: 'PSNR, dB (sRGB), and SSIM at each eye; columns mm to the right, rows mm up'}));
  table.append(element('tr', {}, element('td'), ...eyes.x_mm.map((x) => element('th', {textContent: millimetres(x), scope: 'col'}))));
  eyes.y_mm.forEach((y, row) => {
    table.append(element('tr', {}, element('th', {textContent: millimetres(y), scope: 'row'}), ...eyes.x_mm.map((x, column) => {
      const view = viewAt({row, column});
      const cell = element('td', {textContent: decibels(view)},
        element('small', {textContent: similarity(view)}));
      cell.dataset.row = row;
      cell.dataset.column = column;
      cell.style.background = ground(view);
      cell.style.color = '#1a1f27';
      return cell;
    })));
  });
  for (const comparison of data.metrics.tables) {
    const rows = comparison.rows.map((row) => element('tr', {}, ...row.map((text) => element('td', {textContent: text}))));
    byId('comparisons').append(element('div', {className: 'scroll'}, element('table', {},
      element('caption', {textContent: comparison.title}),
      element('tr', {}, ...comparison.columns.map((text) => element('th', {textContent: text, scope: 'col'}))), ...rows)));
  }
}

function listenToControls() {
  byId('modes').addEventListener('change', (event) => { eye.mode = event.target.value; draw(); });
  byId('blend').addEventListener('change', (event) => { eye.blend = event.target.checked; draw(); });
  const theme = byId('theme'), root = document.documentElement;
  const isDark = () => root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
  const label = () => { theme.textContent = isDark() ? 'Light' : 'Dark'; theme.setAttribute('aria-label', `Switch to ${isDark() ? 'light' : 'dark'} colours`); };
  theme.removeAttribute('aria-pressed');
  theme.addEventListener('click', () => { root.dataset.theme = isDark() ? 'light' : 'dark'; label(); });
  label();
}

byId('title').textContent = data.title;
byId('subtitle').textContent = data.subtitle;
byId('foot').textContent = data.foot;
canvas.width = eyes.width;
canvas.height = eyes.height;
canvas.style.setProperty('--aspect', eyes.width / eyes.height);
showFocus();
showCapture();
showLayers();
showSteps();
showCutoff();
showFacts();
showMetrics();
drawMap();
listenToCanvas();
listenToControls();
draw();
