// The report of a run: wires player, rope and plots together.

const INSTANTS = 8;

function start() {
  if (!DATA.time) return;
  const player = new Player(DATA.span), times = unpack(DATA.time);
  const signals = {};
  const values = (name) => (signals[name] ??= unpack(DATA.signals[name].values));

  byId("player").hidden = byId("plots-section").hidden = false;
  const plots = makePlots(player, times, values);
  const rope = DATA.ropes.length ? makeRope(player, times, values) : () => {};
  const drawPlots = (some = plots) => {
    const width = Number(byId("window").value), [from, to] = DATA.span;
    // the plots move under the cursor, but never beyond the record
    const left = Math.min(Math.max(from, player.t - width / 2), Math.max(from, to - width));
    for (const plot of some) plot.draw(width ? left : from, width ? Math.min(to, left + width) : to);
  };
  // while time moves only the plots in sight follow, the others when they come into sight
  const follow = () => {
    const some = plots.filter((plot) => plot.inSight());
    if (Number(byId("window").value)) drawPlots(some);
    else for (const plot of some) plot.move(player.t);
  };
  const drawAll = () => {
    rope();
    drawPlots();
    drawTrack(player);
  };
  byId("window").addEventListener("change", () => drawPlots());
  player.onMove(follow);
  window.addEventListener("scroll", () => requestAnimationFrame(follow), { passive: true });

  makeReadout(player, times, values);
  explainMarks();
  drawAll();
  player.go(opening(times, values));
  player.followAddress();
  window.addEventListener("resize", drawAll);
  const print = (width) => {
    TimePlot.paper = width;
    drawPlots();
  };
  window.addEventListener("beforeprint", () => print(400));
  window.addEventListener("afterprint", () => print(0));
}

// what matters most: the hardest strike, else what the verdict names
function opening(times, values) {
  let found = { force: 0, t: DATA.open ?? DATA.span[0] };
  for (const name of Object.keys(DATA.signals).filter((each) => /(^|\.)contact\.\w+$/.test(each))) {
    values(name).forEach((force, k) => (found = force > found.force ? { force, t: times[k] } : found));
  }
  return found.t;
}

function makePlots(player, times, values) {
  const home = byId("plots"), plots = [];
  let group = "";
  const quiet = [];
  // behind the largest stress, or behind all when that is not drawn
  let left = DATA.along.flatMap(({ maps }) => maps);
  const maps = () => {
    for (const map of left) {
      if (map.quiet) quiet.push(`${map.title} (${short(unpack(map.values)[0])} ${map.unit})`);
      else plots.push(new AlongPlot(home, map, times, player));
    }
    left = [];
  };
  DATA.panels.forEach((panel, k) => {
    if (panel.quiet) {
      quiet.push(`${panel.title} (${panel.lines.map((line) => `${line.label} ${short(values(line.signal)[0] * line.factor)}`).join(", ")}${panel.unit === "1" ? "" : ` ${panel.unit}`})`);
      return;
    }
    if (panel.group !== group) add(home, "h3", {}, (group = panel.group));
    const lines = panel.lines.map((line) => {
      const raw = values(line.signal), from = line.from_start ? raw[0] : 0;
      return { label: line.label, style: line.style, values: raw.map((value) => line.factor * (value - from)) };
    });
    plots.push(new TimePlot(home, { ...panel, id: `p${k}` }, times, lines, player));
    if (panel.group === "Stress") maps();
  });
  maps();
  add(home, "h3", {}, "Any signal");
  plots.push(freePlot(home, player, times, values));
  const [along] = DATA.along;
  if (along && along.note) add(home, "p", { class: "hint wide", id: "along-note" }, along.note);
  if (quiet.length) add(home, "p", { class: "hint wide" }, `Nothing moved in: ${quiet.join("; ")}.`);
  return plots;
}

// one plot whose signal the reader chooses
function freePlot(home, player, times, values) {
  const names = Object.keys(DATA.signals), line = { label: "", style: "a", values: [] };
  const panel = { id: "free", title: "", unit: "", group: "", min_range: 0, limit: null };
  const plot = new TimePlot(home, panel, times, [line], player);
  const select = document.createElement("select");
  select.id = "any";
  select.setAttribute("aria-label", "signal");
  for (const name of names) {
    const unit = DATA.signals[name].unit;
    add(select, "option", { value: name }, unit ? `${name} [${unit}]` : name);
  }
  plot.figure.querySelector("strong").replaceWith(select);
  const choose = () => {
    line.values = values(select.value);
    panel.steps = /^count\.|\.slipping$|\.valid$|limited$/.test(select.value);
  };
  choose();
  select.addEventListener("change", () => {
    choose();
    plot.draw(plot.from, plot.to);
  });
  return plot;
}

function makeRope(player, times, values) {
  const signal = (name, t) => (name in DATA.signals ? values(name)[indexBefore(times, t)] : NaN);
  byId("stage").hidden = byId("instants-section").hidden = false;
  const curves = new Ropes(DATA.ropes), [low] = curves.spread(1), [left, right] = curves.spread(0);
  const shaft = { low: low - 1, high: DATA.sheave.height + DATA.sheave.radius + 1 };
  const bodies = new Shaft(DATA.shaft, signal), loop = new RopeView(byId("loop"), curves, null, bodies);
  const slim = new RopeView(byId("overview-true"), curves, shaft, bodies);
  const wide = new RopeView(byId("overview-wide"), curves, shaft, bodies);
  const all = [loop, slim, wide];
  // a shaft that is drawn has a shape of its own
  if (bodies.walled || DATA.shaft.dividers.length) byId("stretch").value = "1";
  const draw = () => all.forEach((view) => view.draw(player.t));

  const thumbs = Array.from({ length: INSTANTS }, (_, k) => {
    const t = DATA.span[0] + ((DATA.span[1] - DATA.span[0]) * k) / (INSTANTS - 1);
    const figure = add(byId("instants"), "figure");
    const view = new RopeView(add(figure, "svg", { role: "img", "aria-label": `loop at ${t.toFixed(1)} s` }), curves, null, bodies);
    add(figure, "figcaption", {}, `${t.toFixed(1)} s`);
    figure.addEventListener("click", () => player.go(t));
    return { view, t };
  });
  const drawThumbs = () => {
    const [near, far] = curves.spread(2);
    for (const { view, t } of thumbs) {
      view.stretch = loop.stretch;
      // all that ever happens fits in, seen from the side by half
      view.across = Math.max(5, 1.1 * (right - left) + 0.55 * view.stretch[2] * (far - near));
      view.resize();
      view.draw(t);
    }
  };
  const stretch = () => {
    loop.stretch = [1, 1, Number(byId("stretch").value)];
    draw();
    drawThumbs();
  };
  const resize = () => {
    all.forEach((view) => view.resize());
    // as wide as the drawing allows, a round number
    const room = (0.8 * wide.width) / (((right - left) * wide.height) / (shaft.high - shaft.low));
    const factor = Math.max(1, Math.floor(room));
    wide.stretch = [factor, 1, 1];
    byId("wide-caption").textContent = `wide × ${factor}`;
    stretch();
  };
  loop.show(opening(times, values));
  loop.listen(draw);
  byId("views").addEventListener("click", ({ target }) => {
    if (target.dataset.view) [loop.turn, loop.tilt] = VIEWS[target.dataset.view];
    if (target.dataset.zoom) loop.zoom(Number(target.dataset.zoom));
    draw();
  });
  byId("stretch").addEventListener("change", stretch);
  player.onMove(draw);
  return resize;
}

// numbers at the cursor beside the rope
function makeReadout(player, times, values) {
  const wanted = [
    ["conveyance.left.y", "left conveyance", "m", 1], ["conveyance.left.vy", "speed", "m/s", 1],
    ["drive.torque", "motor torque", "kN m", 1e-3], ["drive.tension_ratio", "tension ratio", "", 1],
    ["left.fy", "pull, left", "kN", -1e-3 * DATA.alike], ["right.fy", "pull, right", "kN", -1e-3 * DATA.alike],
    ["loop.y", "loop, lowest point", "m", 1], ["loop.x", "in plane, from its place", "m", 1], ["loop.z", "out of plane, from its place", "m", 1],
    ["loop.yaw", "yaw", "deg", 180 / Math.PI], ["loop.clearance", "clearance", "m", 1],
    ["stress.bending_max", "largest bending stress", "MPa", 1e-6],
    ["loop.rise", "rise of the loop", "m", 1], ["loop.sideways", "from midway", "m", 1],
    ...["lining", "conveyance", "head_ropes", "divider", "floor"].filter((kind) => `clearance.${kind}` in DATA.signals)
      .flatMap((kind) => [[`clearance.${kind}`, `to ${kind.replace("_", " ")}`, "m", 1], [`contact.${kind}`, `pressed by ${kind.replace("_", " ")}`, "N", 1]]),
  ].filter(([name]) => name in DATA.signals);
  const table = byId("readout");
  const cells = wanted.map(([, label, unit]) => {
    const row = add(table, "tr");
    add(row, "td", {}, label);
    const cell = add(row, "td", { class: "value" });
    add(row, "td", { class: "unit" }, unit);
    return cell;
  });
  const states = ["left", "right"].filter((end) => DATA.swivels[end]).map((end) => {
    const row = add(table, "tr");
    add(row, "td", {}, `${end} swivel`);
    return [end, add(row, "td", { class: "value", colspan: 2 })];
  });
  player.onMove((t) => {
    byId("readout-time").textContent = `${t.toFixed(2)} s`;
    const k = indexBefore(times, t);
    wanted.forEach(([name, , , factor], i) => (cells[i].textContent = short(factor * values(name)[k])));
    for (const [end, cell] of states) {
      const slips = DATA.slips[end].some(([a, b]) => a <= t && t < b);
      cell.textContent = slips ? "slips" : DATA.locked.includes(end) ? "locked" : "sticks";
      cell.className = slips ? `value slips ${end}` : "value";
    }
  });
}

function explainMarks() {
  const parts = [], slipping = DATA.slips.left.length + DATA.slips.right.length;
  if (slipping) parts.push("Bands on top: a swivel slips, left blue, right orange.");
  else if (DATA.locked.length === 2) parts.push("The swivels are locked.");
  else if (DATA.swivels.left || DATA.swivels.right) parts.push("No swivel slipped.");
  if (DATA.transformations.length) parts.push(`Ticks at the bottom: the mesh was transformed (${DATA.transformations.length} times).`);
  if (DATA.marks.length) parts.push(`Dashed: ${DATA.marks.map((mark) => `${mark.label} at ${mark.t.toFixed(2)} s`).join(", ")}.`);
  byId("legend").textContent = parts.join(" ");
}

// the same marks over the slider
function drawTrack(player) {
  const svg = clear(byId("track")), width = Math.max(60, svg.clientWidth), height = 12;
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  // the slider's knob, 16 px wide, does not reach the ends with its middle
  const x = (t) => 8 + ((t - player.start) / (player.end - player.start || 1)) * (width - 16);
  ["left", "right"].forEach((end, k) => {
    for (const [a, b] of DATA.slips[end]) {
      add(svg, "rect", { class: `slip ${end}`, x: x(a), width: Math.max(1, x(b) - x(a)), y: 4 * k, height: 3 });
    }
  });
  for (const t of DATA.transformations) add(svg, "line", { class: "transformation", x1: x(t), x2: x(t), y1: 8, y2: 12 });
  for (const mark of DATA.marks) add(svg, "line", { class: "mark", x1: x(mark.t), x2: x(mark.t), y1: 0, y2: 12 });
}

start();
