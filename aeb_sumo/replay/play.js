// ---- what it says ---------------------------------------------------------------------------------------------------

const number = (v, digits) => v.toFixed(digits).replace("-", "\u2212");

function says(world) {
  const gap = value(world.gap, world, now), speed = value(world.speed, world, now), ttc = world.ttc[place(world, now)[0]];
  const p = pose(world, D.ego, now), brake = value(world.brake, world, now), parts = [];
  if (speed !== null) parts.push(`${D.ego}: ${number(speed * 3.6, 0)} km/h (${number(speed, 1)} m/s)`);
  else parts.push(`${D.ego} is not on the road`);
  if (gap !== null) parts.push(`gap ${number(gap, 1)} m`);
  if (ttc !== null) parts.push(`TTC ${number(ttc, 1)} s`);
  if (p && p.wrecked) parts.push("crashed");
  else if (p && (p.phase || brake > 0.05)) parts.push(`AEB ${PHASES[p.phase] || "lets go"}${brake > 0.05 ? `, ${number(brake, 1)} m/s\u00b2` : ""}`);
  return parts.map((part) => part.replaceAll(" ", "\u00a0")).join(" \u00b7 ");
}

// ---- the charts -----------------------------------------------------------------------------------------------------

const CHARTS = [
  { id: "gap", floor: 10, cap: 60, unit: "m", curves: [["gap", "gap", 1]] },
  { id: "speed", floor: 20, cap: 1e9, unit: "km/h", curves: [["other", "other", 3.6], ["speed", "", 3.6]] },
  { id: "decel", floor: 8, cap: 12, unit: "m/s\u00b2", area: "brake", curves: [["decel", "", 1]] },
];

function make(tag, attributes, parent, text) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [k, v] of Object.entries(attributes)) node.setAttribute(k, v);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

/** SVG path of a curve, with gaps where it is not known or too high; down to a base, if there is one. */
function trace(world, curve, x, y, factor, high, base) {
  let d = "", pen = false, start = 0;
  curve.forEach((v, k) => {
    if (v === null || v * factor > high) { if (pen && base !== undefined) d += `L${x(world.t[k - 1])},${base}L${start},${base}Z`; pen = false; return; }
    if (!pen) { start = x(world.t[k]); d += base === undefined ? "" : `M${start},${base}`; }
    d += `${pen || base !== undefined ? "L" : "M"}${x(world.t[k]).toFixed(1)},${y(v * factor).toFixed(1)}`;
    pen = true;
  });
  return pen && base !== undefined ? `${d}L${x(world.t[curve.length - 1])},${base}Z` : d;
}

function chart(spec) {
  const host = by(spec.id), w = Math.max(host.clientWidth, 200), h = 150, left = 34, right = 8, top = 8, bottom = 20;
  const all = WORLDS.flatMap((world) => spec.curves.flatMap(([key, , f]) => world[key].filter((v) => v !== null).map((v) => v * f)));
  const high = Math.min(Math.max(spec.floor, ...all) * 1.05, spec.cap);
  const x = (t) => left + ((t - FIRST) / (LAST - FIRST || 1)) * (w - left - right);
  const y = (v) => h - bottom - (Math.min(Math.max(v, 0), high) / high) * (h - bottom - top);
  host.replaceChildren();
  const svg = make("svg", { viewBox: `0 0 ${w} ${h}`, height: h, "aria-hidden": "true" }, host);
  const raw = high / 4, ten = 10 ** Math.floor(Math.log10(raw)), tick = [1, 2, 2.5, 5, 10].map((m) => m * ten).find((m) => m >= raw);
  for (let v = 0; v <= high; v += tick) {
    make("line", { x1: left, x2: w - right, y1: y(v), y2: y(v), class: "grid" }, svg);
    make("text", { x: left - 5, y: y(v) + 4, "text-anchor": "end" }, svg, String(Math.round(v * 10) / 10));
  }
  const every = LAST - FIRST > 24 ? 5 : LAST - FIRST > 12 || w < 300 ? 2 : 1;
  for (let t = Math.ceil(FIRST / every) * every; t <= LAST; t += every) {
    make("text", { x: x(t), y: h - 5, "text-anchor": "middle" }, svg, number(t, 0) + (t === 0 ? " s" : ""));
  }
  make("line", { x1: x(0), x2: x(0), y1: top, y2: h - bottom, class: "zero" }, svg);
  if (WORLDS.length > 1) make("line", { x1: x(D.parting), x2: x(D.parting), y1: top, y2: h - bottom, class: "parting" }, svg);
  WORLDS.forEach((world, n) => {
    if (spec.area) make("path", { d: trace(world, world[spec.area], x, y, 1, high, y(0)), class: "area" }, svg);
    for (const [key, kind, f] of spec.curves) make("path", { d: trace(world, world[key], x, y, f, high), class: `line ${kind} w${n}` }, svg);
  });
  spec.cursor = make("line", { y1: top, y2: h - bottom, class: "cursor" }, svg);
  const [key, kind, factor] = spec.curves[spec.curves.length - 1];
  spec.dots = WORLDS.map(() => make("circle", { r: 4, class: `dot ${kind}` }, svg));
  spec.move = () => {
    spec.cursor.setAttribute("x1", x(now));
    spec.cursor.setAttribute("x2", x(now));
    WORLDS.forEach((world, n) => {
      const v = value(world[key], world, now);
      spec.dots[n].setAttribute("visibility", v === null ? "hidden" : "visible");
      if (v !== null) { spec.dots[n].setAttribute("cx", x(now)); spec.dots[n].setAttribute("cy", y(v * factor)); }
    });
  };
  const seek = (event) => {
    const box = svg.getBoundingClientRect();
    stop();
    go(FIRST + (((event.clientX - box.left) / box.width) * w - left) / (w - left - right) * (LAST - FIRST));
  };
  svg.addEventListener("pointerdown", seek);
  svg.addEventListener("pointermove", (event) => { if (event.buttons) seek(event); });
}

// ---- playing --------------------------------------------------------------------------------------------------------

function show() {
  WORLDS.forEach((world, n) => {
    view(by(`view${n}`), world, WORLDS[1 - n]);
    by(`now${n}`).textContent = says(world);
  });
  for (const spec of CHARTS) spec.move();
  const text = `${number(now, 1)} s`;
  by("time").value = now;
  by("time").setAttribute("aria-valuetext", text);
  by("clock").textContent = `t = ${text}`;
}

function go(t) {
  now = Math.min(Math.max(t, FIRST), LAST);
  show();
}

function stop() {
  playing = false;
  by("play").textContent = "Play";
}

function play() {
  if (playing) { stop(); return; }
  if (now >= LAST - 1e-6) now = FIRST;
  playing = true;
  by("play").textContent = "Pause";
  before = performance.now();
  requestAnimationFrame(tick);
}

function tick(moment) {
  if (!playing) return;
  const ahead = (Math.max(moment - before, 0) / 1000) * Number(by("rate").value);
  // Who wants no motion gets four pictures per second.
  if (!still.matches || moment - before > 250) {
    before = moment;
    go(now + ahead);
    if (now >= LAST) { stop(); return; }
  }
  requestAnimationFrame(tick);
}

function paint() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["back", "ink", "ground", "road", "mark", "bicycle", "foot", "wall", "ego", "other", "crashed", "rest", "edge", "lights", "aeb", "red", "yellow", "green"]) {
    colours[name] = style.getPropertyValue(`--${name}`).trim();
  }
}

function lay() {
  for (const spec of CHARTS) chart(spec);
  show();
}

function wider(factor) {
  zoom = Math.min(Math.max(zoom * factor, 0.25), 6);
  show();
}

function fragment() {
  const told = /[#&]t=(-?[\d.]+)/.exec(location.hash);
  if (told) { stop(); go(Number(told[1])); }
}

by("time").min = FIRST;
by("time").max = LAST;
by("time").addEventListener("input", () => { stop(); go(Number(by("time").value)); });
by("play").addEventListener("click", play);
by("in").addEventListener("click", () => wider(1.4));
by("out").addEventListener("click", () => wider(1 / 1.4));
window.addEventListener("hashchange", fragment);
window.addEventListener("resize", lay);
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { paint(); show(); });
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || /SELECT|BUTTON|SUMMARY/.test(event.target.tagName)) return;
  const keys = {
    " ": play, "+": () => wider(1.4), "-": () => wider(1 / 1.4),
    ArrowLeft: () => { stop(); go(now - STEP); }, ArrowRight: () => { stop(); go(now + STEP); },
    Home: () => { stop(); go(FIRST); }, End: () => { stop(); go(LAST); },
  };
  if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
});
paint();
lay();
fragment();
