// The report of a study: parallel coordinates, a scatter plot and a sortable table that mark the same runs.
// A run is its row's place in the table that Python was given; a column's values are numbers, words or null.

const COLUMNS = DATA.columns.map((column) => ({ ...column, scale: makeAxis(column) }));
const AXIS = 96; // px that an axis, or a column of the table, takes
const SHOWN = new Set(); // places of the columns that are shown
let AXES = []; // of these, what is drawn
const NAME = 13, LETTER = 6; // letters in a line of an axis's name; px that a letter of a tick takes at most
const RUNS = DATA.columns.length ? DATA.columns[0].values.map((_, k) => k) : [];
const best = new Set(DATA.best);
const failed = (run) => DATA.causes[run] !== "";
const kept = new Map(); // column -> [lo, hi] as parts of its axis
let marked = null, sorted = { column: null, down: false };

// place of a value on an axis, 0 to 1, and the ticks of that axis; words stand in their order of appearance
function makeAxis(column) {
  const present = column.values.filter((value) => value !== null);
  if (present.some((value) => typeof value !== "number")) {
    const words = [...new Set(present.map(String))], part = (k) => (words.length > 1 ? k / (words.length - 1) : 0.5);
    return { place: (value) => part(words.indexOf(String(value))), ticks: words.map((word, k) => [part(k), clipped(word)]) };
  }
  const all = [...present, ...column.bounds.map(([bound]) => bound)]; // bounds are seen, too
  let lo = Math.min(...all), hi = Math.max(...all);
  if (!(hi > lo)) [lo, hi] = present.length ? [lo - (Math.abs(lo) || 1) / 2, lo + (Math.abs(lo) || 1) / 2] : [0, 1];
  [lo, hi] = [lo - 0.04 * (hi - lo), hi + 0.04 * (hi - lo)]; // the outermost runs stand clear of the ends
  const { values, step } = ticks(lo, hi, 5), place = (value) => (value - lo) / (hi - lo);
  return { place, ticks: values.map((value) => [place(value), tickText(value, step)]) };
}

// a word on an axis must not reach the next one
function clipped(word) {
  return word.length > 15 ? `${word.slice(0, 14)}…` : word;
}

function shown(run) {
  return [...kept].every(([column, [lo, hi]]) => {
    const value = COLUMNS[column].values[run];
    if (value === null) return false;
    const part = COLUMNS[column].scale.place(value);
    return part >= lo - 1e-9 && part <= hi + 1e-9;
  });
}

function kind(run) {
  return [
    failed(run) ? "failed" : "", best.has(run) ? "best" : "", run === marked ? "marked" : "", shown(run) ? "" : "faded",
  ].filter(Boolean).join(" ");
}

// runs outside of the chosen ranges at the back, then the rest, the failed ones, the best and the marked one in front
function inOrder() {
  const rank = (run) => (run === marked ? 3 : best.has(run) ? 2 : failed(run) ? 1 : 0) + (shown(run) ? 0 : -4);
  return [...RUNS].sort((a, b) => rank(a) - rank(b));
}

function mark(run) {
  marked = run === marked ? null : run;
  drawAll();
}

// columns for which the page has room
function room() {
  return Math.max(3, Math.floor(byId("parallel").parentElement.clientWidth / AXIS) - 1);
}

function choose() {
  AXES = [...SHOWN].filter((k) => COLUMNS[k].axis).sort((a, b) => a - b);
  for (const k of [...kept.keys()]) if (!SHOWN.has(k)) kept.delete(k);
  byId("columns-title").textContent = `Columns: ${SHOWN.size} of ${COLUMNS.length} are shown`;
}

function drawChooser() {
  COLUMNS.forEach(({ name }, k) => {
    const label = add(byId("columns"), "label"), box = add(label, "input", { type: "checkbox" });
    box.checked = SHOWN.has(k);
    label.append(` ${name}`);
    box.addEventListener("change", () => {
      SHOWN[box.checked ? "add" : "delete"](k);
      choose();
      drawAll();
    });
  });
}

function drawParallel() {
  const svg = clear(byId("parallel")), height = 394, top = 60, bottom = height - 14;
  const width = Math.max(svg.parentElement.clientWidth, AXES.length > room() ? AXIS * AXES.length : 0);
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.style.width = `${width}px`;
  const x = (k) => 48 + (AXES.indexOf(k) * (width - 130)) / Math.max(1, AXES.length - 1), y = (part) => bottom - part * (bottom - top);
  svg.style.setProperty("--each", Math.min(0.35, Math.max(0.01, 100 / inOrder().length)));  // thousands would be one patch
  for (const run of inOrder()) {
    let d = "", open = false;
    AXES.forEach((k) => {
      const { values, scale } = COLUMNS[k];
      if (values[run] !== null) d += `${open ? "L" : "M"}${x(k).toFixed(1)} ${y(scale.place(values[run])).toFixed(1)}`;
      open = values[run] !== null;
    });
    const path = add(svg, "path", { class: `run-line ${kind(run)}`, d, "data-run": run });
    add(path, "title", {}, `run ${run + 1}`);
    path.addEventListener("click", () => mark(run));
  }
  AXES.forEach((k) => {
    const column = COLUMNS[k];
    const group = add(svg, "g", { class: "axis" });
    add(group, "line", { x1: x(k), x2: x(k), y1: top, y2: bottom });
    for (const [part, text] of column.scale.ticks) {
      add(group, "line", { x1: x(k) - 3, x2: x(k) + 3, y1: y(part), y2: y(part) });
      add(group, "text", { class: "tick halo", x: x(k) + 5, y: y(part) + 3.5 }, text);
    }
    for (const [bound, sense] of column.bounds) {
      const at = y(column.scale.place(bound)), beyond = { class: "beyond", x: x(k) - 4, width: 8 };
      add(group, "rect", sense > 0 ? { ...beyond, y: top, height: at - top } : { ...beyond, y: at, height: bottom - at });
      add(add(group, "line", { class: "bound", x1: x(k) - 12, x2: x(k) + 12, y1: at, y2: at }), "title", {}, boundText(column, bound, sense));
    }
    const name = add(group, "text", { class: `name ${column.role}`, x: x(k), "text-anchor": "middle", y: 12 });
    wrapped(column.name).forEach((text, i) => add(name, "tspan", { x: x(k), dy: i ? 12 : 0 }, text));
    if (column.unit) add(name, "tspan", { x: x(k), dy: 12, class: "unit" }, `[${column.unit}]`);
    name.addEventListener("click", () => {
      kept.delete(k);
      drawAll();
    });
    const range = kept.get(k);
    if (range) add(group, "rect", { class: "range", x: x(k) - 7, width: 14, y: y(range[1]), height: y(range[0]) - y(range[1]) });
    brush(add(group, "rect", { class: "brush", x: x(k) - 12, width: 24, y: top, height: bottom - top }), k, (event) => {
      const box = svg.getBoundingClientRect();
      const part = (bottom - ((event.clientY - box.top) * height) / box.height) / (bottom - top);
      return Math.min(1, Math.max(0, part));
    });
  });
}

function brush(target, column, part) {
  target.addEventListener("pointerdown", (event) => {
    const from = part(event);
    // the axes are drawn anew while the pointer moves, so the window listens
    const move = (moved) => {
      const to = part(moved);
      if (Math.abs(to - from) < 0.02) return;
      kept.set(column, [Math.min(from, to), Math.max(from, to)]);
      drawAll();
    };
    const end = () => {
      window.removeEventListener("pointermove", move);
      window.removeEventListener("pointerup", end);
      window.removeEventListener("pointercancel", end);
    };
    window.addEventListener("pointermove", move);
    window.addEventListener("pointerup", end);
    window.addEventListener("pointercancel", end);
    event.preventDefault();
  });
}

// a name in lines that do not reach the next axis, of three at most
function wrapped(name) {
  const words = name.split(/[ _]|(?<=\.)/), lines = [""];
  for (const word of words) {
    if (`${lines[lines.length - 1]} ${word}`.replace(". ", ".").length > NAME && lines[lines.length - 1]) lines.push("");
    lines[lines.length - 1] = `${lines[lines.length - 1]}${lines[lines.length - 1].endsWith(".") ? "" : " "}${word}`.trim();
  }
  return (lines.length > 3 ? [...lines.slice(0, 2), `${lines[2]}…`] : lines).map(clipped);
}

function drawScatter() {
  const svg = clear(byId("scatter")), width = Math.max(280, svg.clientWidth), height = Math.min(420, Math.max(280, width * 0.6));
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const [across, up] = ["across", "up"].map((id) => COLUMNS[Number(byId(id).value)]);
  const room = (scale) => LETTER * Math.max(0, ...scale.ticks.map(([, text]) => text.length)); // px that its longest tick takes
  const left = Math.max(62, 12 + room(up.scale)), right = Math.max(20, room(across.scale) / 2);
  const x = (part) => left + part * (width - left - right), y = (part) => height - 36 - part * (height - 54);
  let taken = 0; // px, by the ticks to the left
  for (const [part, text] of across.scale.ticks) {
    add(svg, "line", { class: "grid", x1: x(part), x2: x(part), y1: y(0), y2: y(1) });
    const half = (LETTER * text.length) / 2;
    if (x(part) - half < taken) continue;
    add(svg, "text", { class: "tick", x: x(part), y: y(0) + 16, "text-anchor": "middle" }, text);
    taken = x(part) + half;
  }
  for (const [part, text] of up.scale.ticks) {
    add(svg, "line", { class: "grid", x1: x(0), x2: x(1), y1: y(part), y2: y(part) });
    add(svg, "text", { class: "tick", x: x(0) - 8, y: y(part) + 3.5, "text-anchor": "end" }, text);
  }
  const full = ({ name, unit }) => (unit ? `${name} [${unit}]` : name);
  add(svg, "text", { class: "tick", x: x(1), y: height - 4, "text-anchor": "end" }, full(across));
  add(svg, "text", { class: "tick", x: 4, y: 11 }, full(up));
  for (const [bound, sense] of across.bounds) {
    const at = x(across.scale.place(bound));
    add(add(svg, "line", { class: "bound", x1: at, x2: at, y1: y(0), y2: y(1) }), "title", {}, boundText(across, bound, sense));
  }
  for (const [bound, sense] of up.bounds) {
    const at = y(up.scale.place(bound));
    add(add(svg, "line", { class: "bound", x1: x(0), x2: x(1), y1: at, y2: at }), "title", {}, boundText(up, bound, sense));
  }
  drawFront(svg, across, up, (a, b) => [x(across.scale.place(a)), y(up.scale.place(b))]);
  for (const run of inOrder()) {
    const [a, b] = [across.values[run], up.values[run]];
    if (a === null || b === null) continue;
    const place = { cx: x(across.scale.place(a)).toFixed(1), cy: y(up.scale.place(b)).toFixed(1) };
    const dot = add(svg, "circle", { class: `dot ${kind(run)}`, ...place, r: best.has(run) || run === marked ? 6 : 4 });
    add(dot, "title", {}, `run ${run + 1}: ${valueText(a)}, ${valueText(b)}`);
    dot.addEventListener("click", () => mark(run));
  }
}

// Pareto: choices of which no other one is better in both metrics, each at the worst of its runs
function drawFront(svg, across, up, place) {
  byId("front").textContent = "";
  if (!across.better || !up.better || across === up) return;
  const worst = new Map(); // choice -> its worst values; null where a run failed or has none
  for (const run of RUNS) {
    const found = [across, up].map(({ values, better }) => (values[run] === null || failed(run) ? NaN : better * values[run]));
    const before = worst.get(DATA.choices[run]) ?? [-Infinity, -Infinity];
    worst.set(DATA.choices[run], found.map((value, i) => Math.max(value, before[i]))); // NaN stays
  }
  const points = [...worst].filter(([, found]) => !found.some(Number.isNaN));
  const beaten = ([, p]) => points.some(([, q]) => q[0] <= p[0] && q[1] <= p[1] && (q[0] < p[0] || q[1] < p[1]));
  const front = points.filter((point) => !beaten(point)).sort(([, p], [, q]) => p[0] - q[0] || p[1] - q[1]);
  const at = ([, [a, b]]) => place(across.better * a, up.better * b).map((value) => value.toFixed(1));
  let d = "";
  front.forEach((point, k) => {
    const [px, py] = at(point);
    d += k ? `H${px}V${py}` : `M${px} ${py}`; // what lies beyond a step is worse in one of both
  });
  add(svg, "path", { class: "front", d });
  for (const point of front) {
    const [px, py] = at(point), runs = RUNS.filter((run) => DATA.choices[run] === point[0]).map((run) => run + 1);
    add(add(svg, "circle", { class: "front", cx: px, cy: py, r: 8 }), "title", {}, `runs ${runs.join(", ")}, at their worst`);
  }
  const several = points.length < RUNS.filter((run) => !failed(run)).length ? ", each at the worst of its runs" : "";
  byId("front").textContent = `Rings: the ${front.length} of ${points.length} choices of which no other is better in both${several}.`;
}

function boundText({ name, unit }, bound, sense) {
  return `${name} ${sense > 0 ? "below" : "above"} ${short(bound)} ${unit}`.trim();
}

function valueText(value) {
  return value === null ? "–" : typeof value === "number" ? short(value) : String(value);
}

function compare(a, b) {
  if (a === null || b === null) return a === b ? 0 : a === null ? 1 : -1; // what is missing goes last
  const order = typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
  return sorted.down ? -order : order;
}

function drawTable() {
  const table = clear(byId("runs")), head = add(add(table, "thead"), "tr"), body = add(table, "tbody");
  const heading = (text, role, column) => {
    const arrow = sorted.column !== column ? "" : sorted.down ? " ▼" : " ▲";
    const cell = add(head, "th", { scope: "col" }), button = add(cell, "button", { type: "button", class: role }, text + arrow);
    if (arrow) cell.setAttribute("aria-sort", sorted.down ? "descending" : "ascending");
    button.addEventListener("click", () => {
      sorted = { column, down: sorted.column === column && !sorted.down };
      drawTable();
    });
  };
  heading("run", "", null);
  heading("status", "", "status");
  const places = [...SHOWN].sort((a, b) => a - b), foldable = (text) => text.replace(/(?<=[_.])/g, "\u200b");
  for (const k of places) {
    const { name, unit, role } = COLUMNS[k];
    heading(foldable(unit ? `${name} [${unit}]` : name), role, k);
  }
  const value = (run) => (sorted.column === "status" ? DATA.statuses[run] : sorted.column === null ? run : COLUMNS[sorted.column].values[run]);
  const listed = RUNS.filter((run) => shown(run) || run === marked);
  for (const run of listed.sort((a, b) => compare(value(a), value(b)) || a - b)) {
    const row = add(body, "tr", { class: kind(run), "data-run": run });
    add(row, "td", {}, `${run + 1}${best.has(run) ? " ★" : ""}`);
    add(row, "td", {}, DATA.statuses[run]);
    for (const k of places) {
      const value = COLUMNS[k].values[run];
      add(row, "td", { class: typeof value === "string" ? "word" : "value" }, valueText(value));
    }
    row.addEventListener("click", () => mark(run));
  }
  byId("kept").textContent = kept.size ? `${RUNS.filter(shown).length} of ${RUNS.length} runs are in the chosen ranges.` : "";
}

function drawFailed() {
  const table = clear(byId("failed")), runs = RUNS.filter(failed);
  byId("failed-title").hidden = runs.length === 0;
  if (!runs.length) return;
  const parameters = COLUMNS.filter(({ role }) => role === "parameter"), head = add(add(table, "thead"), "tr"), body = add(table, "tbody");
  const named = ({ name, unit }) => (unit ? `${name} [${unit}]` : name);
  for (const text of ["run", "status", "cause", ...parameters.map(named)]) add(head, "th", {}, text);
  for (const run of runs) {
    const row = add(body, "tr", { class: run === marked ? "marked" : "" });
    for (const text of [run + 1, DATA.statuses[run], DATA.causes[run]]) add(row, "td", {}, String(text));
    for (const { values } of parameters) add(row, "td", { class: "value" }, valueText(values[run]));
    row.addEventListener("click", () => mark(run));
  }
}

function drawAll() {
  drawParallel();
  drawScatter();
  drawTable();
  drawFailed();
}

function start() {
  if (!COLUMNS.length) return;
  COLUMNS.slice(0, room()).forEach((_, k) => SHOWN.add(k));
  choose();
  drawChooser();
  // the two metrics that the study judges by, else what was varied against what matters most
  const axis = (role) => COLUMNS.map((_, k) => k).filter((k) => COLUMNS[k].axis && COLUMNS[k].role === role && !by.includes(k));
  const by = DATA.by.map((asked) => COLUMNS.findIndex(({ name }) => name === asked)).filter((k) => k >= 0);
  const metrics = [...by, ...axis("metric")], judged = by.filter((k) => COLUMNS[k].better);
  const first = judged.length > 1 ? judged[0] : axis("parameter")[0] ?? metrics[1] ?? 0;
  const second = (judged.length > 1 ? judged[1] : metrics[0]) ?? COLUMNS.length - 1;
  for (const [id, chosen] of [["across", first], ["up", second]]) {
    COLUMNS.forEach(({ name }, k) => add(byId(id), "option", { value: k }, name));
    byId(id).value = chosen;
    byId(id).addEventListener("change", drawScatter);
  }
  drawAll();
  window.addEventListener("resize", () => {
    drawParallel();
    drawScatter();
  });
}

start();
