// Time plots: all share the time axis, the cursor, the marks and the bands of slip.

const BAND = 5; // height of a band of slip at the top of a plot, in pixels
const MARGIN = { left: 52, right: 12, top: 19, bottom: 22 }; // names of marks stand on top
const LETTER = 5.5; // width of one in them

class TimePlot {
  // lines: [{label, style, values}]; values are in the panel's unit, one per entry of times
  constructor(parent, panel, times, lines, player) {
    this.panel = panel;
    this.times = times;
    this.lines = lines;
    this.player = player;
    this.figure = add(parent, "figure", { class: "plot" });
    const caption = add(this.figure, "figcaption");
    add(caption, "strong", {}, panel.title);
    add(caption, "span", { class: "unit" }, panel.unit && panel.unit !== "1" ? `[${panel.unit}]` : "");
    this.readings = lines.map((line) => {
      const key = this.addKey(caption, line.style);
      add(key, "span", {}, line.label);
      return add(key, "span", { class: "reading" });
    });
    if (panel.limit) this.limit = add(this.addKey(caption, "limit"), "span", { class: "limit-label" });
    this.svg = add(this.figure, "svg", { class: "chart", role: "img", "aria-label": panel.title });
    const move = (event) => {
      if (event.type === "pointermove" && !(event.buttons & 1)) return;
      const box = this.svg.getBoundingClientRect();
      this.player.go(this.timeAt(((event.clientX - box.left) * this.width) / box.width));
    };
    this.svg.addEventListener("pointerdown", move);
    this.svg.addEventListener("pointermove", move);
  }

  // a sample of a line's style, for its name
  addKey(caption, style) {
    const key = add(caption, "span", { class: "key" });
    add(add(key, "svg", { width: 20, height: 8 }), "line", { class: `line ${style}`, x1: 0, y1: 4, x2: 20, y2: 4 });
    return key;
  }

  inSight() {
    const box = this.figure.getBoundingClientRect();
    return box.bottom > 0 && box.top < window.innerHeight;
  }

  timeAt(px) {
    const inner = this.width - MARGIN.left - MARGIN.right;
    return this.from + ((px - MARGIN.left) / inner) * (this.to - this.from);
  }

  x(t) {
    return MARGIN.left + ((t - this.from) / (this.to - this.from)) * (this.width - MARGIN.left - MARGIN.right);
  }

  // everything but the cursor, for the times from..to
  draw(from, to) {
    this.from = from;
    this.to = to;
    this.width = TimePlot.paper || Math.max(240, this.figure.clientWidth);
    this.height = this.panel.height ?? 170;
    const svg = clear(this.svg), bottom = this.height - MARGIN.bottom;
    svg.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    const first = Math.max(0, indexBefore(this.times, from)), last = Math.min(this.times.length - 1, indexBefore(this.times, to) + 1);
    const [lo, hi] = this.range(first, last);
    this.y = (value) => bottom - ((value - lo) / (hi - lo)) * (bottom - MARGIN.top - 2 * BAND - 4);
    this.drawAxes(lo, hi, bottom);
    const clip = `clip-${this.panel.id}`;
    const area = add(add(svg, "clipPath", { id: clip }), "rect", { x: MARGIN.left, y: 0, height: this.height });
    area.setAttribute("width", this.width - MARGIN.left - MARGIN.right);
    const inside = add(svg, "g", { "clip-path": `url(#${clip})` });
    this.drawEvents(inside, bottom);
    this.drawContent(inside, first, last);
    this.drawNames(inside);
    this.cursor = add(inside, "line", { class: "cursor", y1: MARGIN.top, y2: bottom });
    this.move(this.player.t);
  }

  range(first, last) {
    let lo = Infinity, hi = -Infinity;
    for (const line of this.lines) {
      for (let k = first; k <= last; k++) {
        if (line.values[k] < lo) lo = line.values[k];
        if (line.values[k] > hi) hi = line.values[k];
      }
    }
    if (!(lo <= hi)) return [0, 1];
    const limit = this.panel.limit;
    // a limit far away would flatten the curves: it is only named above the plot
    if (limit && limit.value > lo - 2 * (hi - lo) && limit.value < hi + 2 * (hi - lo)) {
      lo = Math.min(lo, limit.value);
      hi = Math.max(hi, limit.value);
    }
    const least = Math.max(this.panel.min_range, 1e-9, 1e-6 * Math.max(Math.abs(lo), Math.abs(hi)));
    const grow = Math.max(0, least - (hi - lo)) / 2 + 0.04 * Math.max(least, hi - lo);
    return [lo - grow, hi + grow];
  }

  drawAxes(lo, hi, bottom) {
    const left = MARGIN.left, right = this.width - MARGIN.right;
    const across = ticks(this.from, this.to, Math.max(3, this.width / 90)), up = ticks(Math.min(lo, hi), Math.max(lo, hi), 4);
    for (const t of across.values) {
      add(this.svg, "line", { class: "grid", x1: this.x(t), x2: this.x(t), y1: MARGIN.top, y2: bottom });
      add(this.svg, "text", { class: "tick", x: this.x(t), y: bottom + 14, "text-anchor": "middle" }, tickText(t, across.step));
    }
    for (const value of up.values) {
      add(this.svg, "line", { class: "grid", x1: left, x2: right, y1: this.y(value), y2: this.y(value) });
      add(this.svg, "text", { class: "tick", x: left - 5, y: this.y(value) + 3.5, "text-anchor": "end" }, tickText(value, up.step));
    }
    add(this.svg, "text", { class: "tick", x: right, y: this.height - 1, "text-anchor": "end" }, "s");
  }

  // bands of slip, ticks of mesh transformations and named instants, behind the curves
  drawEvents(group, bottom) {
    const tall = bottom - MARGIN.top, whole = this.panel.group === "Swivels";
    ["left", "right"].forEach((end, k) => {
      for (const [a, b] of DATA.slips[end]) {
        const box = { x: this.x(a), width: Math.max(1, this.x(b) - this.x(a)) };
        add(group, "rect", { class: `slip ${end}`, ...box, y: MARGIN.top + k * BAND, height: BAND - 1 });
        if (whole) add(group, "rect", { class: `slip pale ${end}`, ...box, y: MARGIN.top, height: tall });
      }
    });
    for (const t of DATA.transformations) {
      add(group, "line", { class: "transformation", x1: this.x(t), x2: this.x(t), y1: bottom - 6, y2: bottom });
    }
    for (const { t } of DATA.marks) {
      add(group, "line", { class: "mark", x1: this.x(t), x2: this.x(t), y1: MARGIN.top, y2: bottom });
    }
  }

  // names of the marks, above curves, ticks and bands
  drawNames(group) {
    if (!(this.panel.named ?? true)) return;
    const groups = [], names = [];
    for (const mark of DATA.marks) {
      const x = this.x(mark.t), group = groups.at(-1);
      // lines that lie on one another share a name; the text above the plots has them all
      if (group && x - group.x < 8) group.more += 1;
      else groups.push({ x, label: mark.label, more: 0 });
    }
    let free = MARGIN.left; // from here on no name stands
    groups.forEach(({ x, label, more }, k) => {
      const width = LETTER * (label.length + 1), next = k + 1 < groups.length ? groups[k + 1].x : this.width;
      // the name goes where no other one and no other mark is; where there is no such place, the last one counts it
      const before = (next - x <= width || x < free) && x - width > free;
      const fits = before || (next - x > width && x >= free) || !names.length;
      if (fits) names.push({ x, label, more, before });
      else names.at(-1).more += 1 + more;
      free = Math.max(free, fits && !before ? x + width : x);
    });
    for (const { x, label, before, more } of names) {
      const place = { x: x + (before ? -4 : 4), y: MARGIN.top - 5, "text-anchor": before ? "end" : "start" };
      add(group, "text", { class: "mark-label", ...place }, more ? `${label} +${more}` : label);
    }
  }

  drawContent(group, first, last) {
    const limit = this.panel.limit;
    if (limit) {
      const y = this.y(limit.value);
      add(group, "line", { class: "line limit", x1: MARGIN.left, x2: this.width, y1: y, y2: y });
      this.limit.textContent = y > 0 ? limit.label : `${limit.label} ↑`;
    }
    for (const line of this.lines) {
      let path = "", open = false;
      for (let k = first; k <= last; k++) {
        const value = line.values[k];
        if (Number.isFinite(value)) {
          const point = `${this.x(this.times[k]).toFixed(1)} ${this.y(value).toFixed(1)}`;
          path += !open ? `M${point}` : this.panel.steps ? `H${point.split(" ")[0]}V${point.split(" ")[1]}` : `L${point}`;
          open = true;
        } else open = false;
      }
      add(group, "path", { class: `line ${line.style}`, d: path });
    }
  }

  move(t) {
    const x = this.x(t).toFixed(1);
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
    this.lines.forEach((line, k) => (this.readings[k].textContent = short(this.valueAt(line, t))));
  }

  // between two points linearly; counts and flags keep their value until the next one
  valueAt(line, t) {
    const k = indexBefore(this.times, t), next = Math.min(k + 1, this.times.length - 1);
    if (this.panel.steps || next === k) return line.values[k];
    const part = Math.max(0, (t - this.times[k]) / (this.times[next] - this.times[k]));
    return line.values[k] + part * (line.values[next] - line.values[k]);
  }
}

TimePlot.paper = 0; // width while printing, in pixels, which the screen's layout cannot tell; 0 on a screen

// a quantity over the rope's length and time, as a picture with a scale
class AlongPlot extends TimePlot {
  constructor(parent, map, times, player) {
    const panel = { id: map.id, title: map.title, unit: map.unit, group: "Stress", min_range: 0, height: 260, named: false };
    super(parent, panel, times, [], player);
    this.map = map;
    const { rows, columns } = map, { lo, hi } = map.values, from = Math.min(0, lo);
    const canvas = document.createElement("canvas");
    canvas.width = columns;
    canvas.height = rows;
    const context = canvas.getContext("2d"), picture = context.createImageData(columns, rows);
    unpack(map.values).forEach((value, k) => picture.data.set([...shade((value - from) / (hi - from)), 255], 4 * k));
    context.putImageData(picture, 0, 0);
    this.source = canvas.toDataURL("image/png");
    const scale = add(this.figure, "div", { class: "scale" });
    add(scale, "span", {}, short(from));
    for (let k = 0; k < 24; k++) add(scale, "i").style.background = `rgb(${shade(k / 23)})`;
    add(scale, "span", {}, `${short(hi)} ${map.unit}`);
  }

  range() {
    return [this.map.length, 0]; // the left end on top
  }

  drawContent(group) {
    const { span, length } = this.map;
    const box = { x: this.x(span[0]), y: this.y(0), preserveAspectRatio: "none", href: this.source };
    add(group, "image", { ...box, width: this.x(span[1]) - box.x, height: this.y(length) - box.y });
    const place = { x: -this.height / 2 + 10, y: 11, transform: "rotate(-90)", "text-anchor": "middle", class: "tick" };
    add(this.svg, "text", place, "length from the left end [m]");
  }
}

// from white over orange to dark brown: ordered in lightness, so that it serves colour-blind eyes and grey prints
function shade(part) {
  const stops = [[255, 255, 255], [254, 217, 142], [240, 140, 40], [140, 45, 4], [40, 10, 0]];
  const place = Math.min(0.9999, Math.max(0, part || 0)) * (stops.length - 1), k = Math.floor(place);
  return stops[k].map((from, c) => Math.round(from + (place - k) * (stops[k + 1][c] - from)));
}
