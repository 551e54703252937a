"use strict";
const D = JSON.parse(document.getElementById("data").textContent);
const by = (id) => document.getElementById(id);
const WORLDS = D.worlds;
const FIRST = WORLDS[0].t[0];
const LAST = Math.max(...WORLDS.map((w) => w.t[w.t.length - 1]));
const STEP = WORLDS[0].t.length > 1 ? (WORLDS[0].t[WORLDS[0].t.length - 1] - FIRST) / (WORLDS[0].t.length - 1) : 0.1;
const PHASES = ["", "warns", "brakes partially", "brakes fully"];
const still = window.matchMedia("(prefers-reduced-motion: reduce)");
let now = Math.min(Math.max(0, FIRST), LAST), playing = false, zoom = 1, before = 0, colours = {};

// ---- values at an instant -------------------------------------------------------------------------------------------

/** Frame at or before t, and how far on to the next. */
function place(world, t) {
  const f = Math.min(Math.max((t - world.t[0]) / STEP, 0), world.t.length - 1);
  const k = Math.min(Math.floor(f + 1e-6), world.t.length - 1);
  return [k, Math.max(f - k, 0)];
}

/** A curve between its frames; null where it is not known. */
function value(curve, world, t) {
  const [k, s] = place(world, t);
  const a = curve[k], b = k + 1 < curve.length ? curve[k + 1] : null;
  return a === null ? null : b === null || s === 0 ? a : a + (b - a) * s;
}

/** Pose of a road user, or null. */
function pose(world, name, t) {
  const track = world.tracks[name];
  if (!track) return null;
  const [frame, s] = place(world, t), k = frame - track.k;
  if (k < 0 || k >= track.x.length || track.x[k] === null) return null;
  const j = k + 1 < track.x.length && track.x[k + 1] !== null ? k + 1 : k;
  if (j === k && s > 0.5) return null;
  const turn = Math.atan2(Math.sin(track.h[j] - track.h[k]), Math.cos(track.h[j] - track.h[k]));
  const mix = (v) => v[k] + (v[j] - v[k]) * s;
  const contact = world.contacts.some((c) => (c.striker === name || c.struck === name) && c.t <= t);
  return {
    x: mix(track.x), y: mix(track.y), h: track.h[k] + turn * s,
    slows: j > k && (track.v[k] - track.v[j]) / STEP > 1,
    phase: track.a ? Number(track.a[k]) : 0,
    wrecked: contact || (track.w !== null && frame >= track.w && !world.contacts.some((c) => c.striker === name || c.struck === name)),
  };
}

// ---- the view from above --------------------------------------------------------------------------------------------

function path(c, points, close) {
  c.beginPath();
  for (let k = 0; k < points.length; k += 2) c.lineTo(points[k], points[k + 1]);
  if (close) c.closePath();
}

function ground(c) {
  c.lineJoin = "round";
  c.fillStyle = colours.road;
  for (const outline of D.junctions) { path(c, outline, true); c.fill(); }
  for (const edge of [true, false]) {
    for (const lane of D.lanes) {
      if (edge && lane.inside) continue;
      c.strokeStyle = edge ? colours.mark : lane.inside ? (lane.kind === "foot" ? colours.foot : colours.road) : colours[lane.kind];
      c.lineWidth = Math.max(lane.w - (edge || lane.inside ? 0 : 0.25), 0.1);
      path(c, lane.p, false);
      c.stroke();
    }
  }
  c.strokeStyle = colours.wall;
  c.lineWidth = 0.6;
  for (const wall of D.walls) { path(c, wall, false); c.stroke(); }
}

/** A bar per signal at the end of its lane: red is thick, green is thin. */
function signals(c, world) {
  const [frame] = place(world, now);
  for (const lane of D.lanes) {
    const changes = world.lights[lane.id];
    if (!changes) continue;
    const state = changes.filter(([k]) => k <= frame).pop()[1], n = lane.p.length;
    const [x0, y0, x, y] = lane.p.slice(n - 4), turn = Math.atan2(y - y0, x - x0);
    c.save();
    c.translate(x, y);
    c.rotate(turn);
    [...state.toLowerCase()].forEach((letter, k) => {
      const thick = { r: 1, u: 1, y: 0.7, g: 0.4 }[letter];
      if (!thick) return;
      const wide = lane.w / state.length;
      c.fillStyle = letter === "g" ? colours.green : letter === "y" ? colours.yellow : colours.red;
      c.fillRect(-thick, -lane.w / 2 + k * wide + 0.1, thick, wide - 0.2);
    });
    c.restore();
  }
}

function body(c, name, p, px, dashed) {
  const [vclass, length, width] = D.cast[name];
  c.save();
  c.translate(p.x, p.y);
  c.rotate(p.h);
  c.beginPath();
  // Who is on foot would be a speck.
  if (vclass === "pedestrian") c.arc(-length / 2, 0, Math.max(length / 2, 4 * px), 0, 7);
  else c.roundRect(-length, -width / 2, length, width, Math.min(width / 3, 0.5));
  if (dashed) {
    c.setLineDash([4 * px, 3 * px]);
    c.strokeStyle = colours.ego;
    c.lineWidth = 1.5 * px;
    c.stroke();
    c.restore();
    return;
  }
  c.fillStyle = p.wrecked ? colours.crashed : name === D.ego ? colours.ego : name === D.other ? colours.other : colours.rest;
  c.fill();
  const ours = p.wrecked && name === D.ego ? colours.ego : p.wrecked && name === D.other ? colours.other : "";
  c.strokeStyle = ours || colours.edge;
  c.lineWidth = ours ? 2.5 * px : px;
  c.stroke();
  if (p.wrecked) {
    c.strokeStyle = colours.back;
    c.lineWidth = 1.5 * px;
    c.beginPath();
    c.moveTo(-length * 0.85, -width * 0.35); c.lineTo(-length * 0.15, width * 0.35);
    c.moveTo(-length * 0.85, width * 0.35); c.lineTo(-length * 0.15, -width * 0.35);
    c.stroke();
  } else if (length > 1) {
    c.fillStyle = "rgba(255,255,255,0.75)";  // the windscreen: which way it looks
    c.fillRect(-length * 0.32, -width * 0.36, length * 0.1, width * 0.72);
    if (p.slows) {
      c.fillStyle = colours.lights;
      c.fillRect(-length - 2 * px, -width / 2, 3 * px + 0.2, width);
    }
  }
  if (p.phase > 0 && !p.wrecked) {
    c.beginPath();
    c.roundRect(-length - 5 * px, -width / 2 - 5 * px, length + 10 * px, width + 10 * px, 5 * px);
    c.strokeStyle = colours.aeb;
    c.lineWidth = (0.5 + p.phase) * px;
    c.stroke();
  }
  c.restore();
}

/** Where the ego is, or was last, or comes in first. */
function centre(world, t) {
  const p = pose(world, D.ego, t);
  if (p) return p;
  const track = world.tracks[D.ego];
  if (!track) return { x: 0, y: 0 };
  const [k] = place(world, t);
  let at = k < track.k ? 0 : Math.min(k - track.k, track.x.length - 1);
  while (at > 0 && track.x[at] === null) at--;
  return { x: track.x[at], y: track.y[at] };
}

function view(canvas, world, twin) {
  const w = canvas.clientWidth, h = canvas.clientHeight, dense = window.devicePixelRatio || 1;
  if (!w || !h) return;
  if (canvas.width !== Math.round(w * dense)) { canvas.width = Math.round(w * dense); canvas.height = Math.round(h * dense); }
  const c = canvas.getContext("2d"), scale = (w / D.across) * zoom * (w < 400 ? 1.3 : 1), px = 1 / scale, mid = centre(world, now);
  const screen = (x, y) => {
    const dx = x - mid.x, dy = y - mid.y, cos = Math.cos(-D.turn), sin = Math.sin(-D.turn);
    return [w * (0.5 - D.shift) + (dx * cos - dy * sin) * scale, h / 2 - (dx * sin + dy * cos) * scale];
  };
  c.setTransform(dense, 0, 0, dense, 0, 0);
  c.fillStyle = colours.ground;
  c.fillRect(0, 0, w, h);
  c.save();
  c.translate(w * (0.5 - D.shift), h / 2);
  c.scale(scale, -scale);
  c.rotate(-D.turn);
  c.translate(-mid.x, -mid.y);
  ground(c);
  signals(c, world);
  const there = [];
  for (const name of Object.keys(world.tracks)) {
    const p = pose(world, name, now);
    if (p) there.push([name, p]);
  }
  const rank = ([name]) => (name === D.ego ? 2 : name === D.other ? 1 : 0);
  there.sort((a, b) => rank(a) - rank(b));
  for (const [name, p] of there) body(c, name, p, px, false);
  const ghost = twin && now > D.parting ? pose(twin, D.ego, now) : null;
  const own = there.find(([name]) => name === D.ego);
  if (ghost && (!own || Math.hypot(ghost.x - own[1].x, ghost.y - own[1].y) > 0.3)) body(c, D.ego, ghost, px, true);
  c.restore();
  for (const hit of world.contacts.filter((k) => k.t <= now && now < k.t + 1.5)) {
    const [x, y] = screen(hit.x, hit.y);
    c.strokeStyle = colours.crashed;
    c.lineWidth = 3;
    c.beginPath();
    c.arc(x, y, 8 + 14 * (now - hit.t), 0, 7);
    c.stroke();
  }
  c.font = "600 12px system-ui, sans-serif";
  c.textAlign = "center";
  const named = there.filter(([n]) => n === D.ego || n === D.other).map(([name, p]) => {
    const [, length, width] = D.cast[name];
    return [name, p, length, width, ...screen(p.x - (length / 2) * Math.cos(p.h), p.y - (length / 2) * Math.sin(p.h))];
  });
  named.sort((a, b) => a[5] - b[5]);  // the upper one has its name above it
  for (const [name, p, length, width, x, y] of named) {
    const high = (Math.abs(Math.sin(p.h - D.turn)) * length + width) * scale / 2 + 9;
    const up = name === named[0][0] ? y - high : y + high + 8;
    c.lineWidth = 3;
    c.strokeStyle = colours.back;
    c.strokeText(name, x, up);
    c.fillStyle = colours.ink;
    c.fillText(name, x, up);
  }
  const bar = [5, 10, 20, 50].find((m) => m * scale >= 50) || 50;
  c.fillStyle = colours.ink;
  c.fillRect(10, h - 12, bar * scale, 3);
  c.textAlign = "left";
  c.lineWidth = 3;
  c.strokeStyle = colours.back;
  c.strokeText(bar + " m", 10, h - 18);
  c.fillText(bar + " m", 10, h - 18);
}
