// The ropes in space: positions by interpolation between frames, parallel projection, drawn as SVG.
// X to the right, Y up, Z towards the reader of the front view. Turning is about Y first, then about the screen's x.

class Curves {
  constructor(rope) {
    this.name = rope.name;
    this.places = rope.places;
    this.n = rope.points;
    this.t = unpack(rope.t);
    this.axes = ["x", "y", "z"].map((axis) => unpack(rope[axis]));
  }

  // points [x, y, z] from the left to the right end at time t
  at(t) {
    const k = indexBefore(this.t, t), next = Math.min(k + 1, this.t.length - 1);
    const part = next === k ? 0 : Math.max(0, (t - this.t[k]) / (this.t[next] - this.t[k]));
    const points = [];
    for (let i = 0; i < this.n; i++) {
      points.push(this.axes.map((axis) => axis[k * this.n + i] * (1 - part) + axis[next * this.n + i] * part));
    }
    return points;
  }

  spread(axis) {
    let lo = Infinity, hi = -Infinity;
    for (const value of this.axes[axis]) {
      lo = Math.min(lo, value);
      hi = Math.max(hi, value);
    }
    return [lo, hi];
  }

  // centres of both conveyances
  centres(points) {
    return [points[0], points[this.n - 1]].map(([x, y, z], k) => [x - this.places[k][0], y, z - this.places[k][1]]);
  }
}

// all ropes of a hoist
class Ropes {
  constructor(ropes) {
    this.all = ropes.map((rope) => new Curves(rope));
  }

  // ropes that hang at time t, each with its points and its lowest one; at least one, for the drawing
  at(t) {
    const hanging = this.all.filter((rope) => t <= rope.t[rope.t.length - 1] + 1e-3);
    return (hanging.length ? hanging : this.all.slice(0, 1)).map((rope) => {
      const points = rope.at(t), k = lowest(points);
      return { rope, points, k, bottom: points[k] };
    });
  }

  spread(axis) {
    const all = this.all.map((rope) => rope.spread(axis));
    return [Math.min(...all.map(([lo]) => lo)), Math.max(...all.map(([, hi]) => hi))];
  }
}

function lowest(points) {
  let k = 0;
  points.forEach((point, i) => (k = point[1] < points[k][1] ? i : k));
  return k;
}

const VIEWS = { oblique: [-0.6, 0.35], front: [0, 0], side: [-Math.PI / 2, 0], above: [0, Math.PI / 2] };
const NEAR = 20; // m above the loop: what is higher is in the overviews
const CAR = { width: 1.2, height: 3, depth: 1.6 }; // m, a drawing of a conveyance and not its data

class RopeView {
  // fixed: the whole shaft, else the loop's lowest point
  constructor(svg, curves, fixed, shaft) {
    this.svg = svg;
    this.shaft = shaft;
    this.curves = curves;
    this.fixed = fixed;
    [this.turn, this.tilt] = fixed ? VIEWS.front : VIEWS.oblique;
    this.stretch = [1, 1, 1];
    this.across = 7; // m shown over the smaller side, unless fixed
  }

  // as far away as shows the loop, and what is near it: the dividers and the lower conveyance
  show(t) {
    const [{ points, bottom: [, bottom] }] = this.curves.at(t), { car, data } = this.shaft;
    const ends = [points[0], points[points.length - 1]].map(([, y]) => y + car.above + car.height);
    const heights = [...ends, ...data.dividers.map(({ y }) => y + 0.5)].map((y) => y - bottom);
    this.across = Math.max(7, ...heights.filter((above) => above < NEAR).map((above) => 1.35 * above));
  }

  resize() {
    this.width = Math.max(30, this.svg.clientWidth);
    this.height = Math.max(100, this.svg.clientHeight);
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
  }

  project([x, y, z]) {
    const [sx, sy, sz] = this.stretch, [cx, cy, cz] = this.centre;
    const X = (x - cx) * sx, Y = (y - cy) * sy, Z = (z - cz) * sz;
    const depth = -X * Math.sin(this.turn) + Z * Math.cos(this.turn);
    const u = X * Math.cos(this.turn) + Z * Math.sin(this.turn);
    const v = Y * Math.cos(this.tilt) - depth * Math.sin(this.tilt);
    return [this.width / 2 + this.scale * u, this.height / 2 - this.scale * v, depth * Math.cos(this.tilt) + Y * Math.sin(this.tilt)];
  }

  // a smooth path through the points first..last of a curve in space (Catmull-Rom)
  path(points, first = 0, last = points.length - 1) {
    const p = points.map((point) => this.project(point)), text = ([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`;
    let d = `M${text(p[first])}`;
    for (let k = first; k < last; k++) {
      const a = p[Math.max(0, k - 1)], b = p[k], c = p[k + 1], e = p[Math.min(p.length - 1, k + 2)];
      // handles no longer than a third of their own chord: neighbouring points may be unevenly spaced
      const chord = Math.hypot(c[0] - b[0], c[1] - b[1]) / 3;
      const handle = (from, to) => {
        const size = Math.hypot(to[0] - from[0], to[1] - from[1]) || 1;
        return [(chord * (to[0] - from[0])) / size, (chord * (to[1] - from[1])) / size];
      };
      const [out, back] = [handle(a, c), handle(b, e)];
      d += `C${text([b[0] + out[0], b[1] + out[1]])} ${text([c[0] - back[0], c[1] - back[1]])} ${text(c)}`;
    }
    return d;
  }

  draw(t) {
    const ropes = this.curves.at(t), [{ rope, points, bottom }] = ropes, ends = rope.centres(points);
    const svg = clear(this.svg);
    if (this.fixed) {
      this.centre = [0, (this.fixed.low + this.fixed.high) / 2, 0];
      this.scale = (this.height - 12) / (this.fixed.high - this.fixed.low);
    } else {
      this.scale = Math.min(this.width, this.height) / this.across;
      // from the front the bottom is shown in the lower third, from above in the middle
      this.centre = [0, bottom[1] + 0.25 * Math.cos(this.tilt) * (this.height / this.scale), 0];
      const tall = this.height / this.scale / Math.max(0.3, Math.cos(this.tilt));
      [this.low, this.high] = [bottom[1] - 0.3 * tall, bottom[1] + tall];
      this.drawLevels(ropes);
      for (const one of ropes) this.drawTrace(t, one.rope);
    }
    if (this.fixed) this.drawSheave(ends);
    this.shaft.draw(this, t, ends, bottom);
    for (const end of ends) this.drawCar(end);
    for (const one of ropes) {
      const drawn = add(svg, "g", { class: "rope" }), [x, y] = this.project(one.bottom);
      add(drawn, "path", { class: "left", d: this.path(one.points, 0, one.k) });
      add(drawn, "path", { class: "right", d: this.path(one.points, one.k) });
      add(drawn, "circle", { class: "bottom", cx: x.toFixed(2), cy: y.toFixed(2), r: this.fixed ? 2 : 3.5 });
    }
    this.shaft.drawContacts(this, t, ropes);
    svg.dataset.t = t.toFixed(3);
    svg.dataset.bottom = bottom.map((value) => value.toFixed(4)).join(" ");
  }

  line(from, to, kind) {
    const [a, b] = [this.project(from), this.project(to)];
    add(this.svg, "line", { class: kind, x1: a[0].toFixed(1), y1: a[1].toFixed(1), x2: b[0].toFixed(1), y2: b[1].toFixed(1) });
  }

  // level frames at fixed heights of the shaft, to see the motion against, and the plumb lines of the suspensions
  drawLevels(ropes) {
    const { low, high } = this, { values, step } = ticks(low, high, 6), [{ points }] = ropes;
    const half = this.shaft.walled ? this.shaft.reach : [Math.abs(points[0][0]) * 1.6, Math.max(0.3, 1.2 / this.stretch[2])];
    for (const y of values) {
      const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => this.project([a * half[0], y, b * half[1]]));
      add(this.svg, "path", { class: "level", d: `M${corners.map(([a, b]) => `${a.toFixed(1)} ${b.toFixed(1)}`).join("L")}Z` });
      const place = { x: corners[1][0].toFixed(1), y: (corners[1][1] - 3).toFixed(1), "text-anchor": "middle" };
      if (Math.abs(this.tilt) < 1.2) add(this.svg, "text", { class: "tick", ...place }, `${tickText(y, step)} m`);
    }
    for (const end of ropes.flatMap((one) => [one.points[0], one.points[one.points.length - 1]])) {
      this.line([end[0], low, end[2]], [end[0], Math.min(high, end[1]), end[2]], "plumb");
    }
  }

  drawTrace(t, rope) {
    const first = rope.t[0], trace = [];
    for (let back = Math.min(3, t - first); back > 0; back -= 0.1) {
      const points = rope.at(t - back);
      trace.push(points[lowest(points)]);
    }
    const here = rope.at(t);
    trace.push(here[lowest(here)]);
    const d = trace.map((point) => this.project(point)).map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L");
    add(this.svg, "path", { class: "trace", d: `M${d}` });
  }

  drawCar(end) {
    const [x, y, z] = end, car = this.shaft.car, depth = car.depth / (car.real ? 1 : this.stretch[2]);
    const corner = ([a, b, c]) => this.project([x + (a * car.width) / 2, y + car.above + b * car.height, z + (c * depth) / 2]);
    const faces = [
      [[-1, 0, 1], [1, 0, 1], [1, 1, 1], [-1, 1, 1]], [[-1, 0, -1], [1, 0, -1], [1, 1, -1], [-1, 1, -1]],
      [[-1, 0, -1], [-1, 0, 1], [-1, 1, 1], [-1, 1, -1]], [[1, 0, -1], [1, 0, 1], [1, 1, 1], [1, 1, -1]],
      [[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]], [[-1, 1, -1], [1, 1, -1], [1, 1, 1], [-1, 1, 1]],
    ].map((face) => face.map(corner));
    const nearness = (face) => face.reduce((sum, point) => sum + point[2], 0);
    faces.sort((a, b) => nearness(a) - nearness(b));
    for (const face of faces) {
      const d = face.map(([u, v]) => `${u.toFixed(1)} ${v.toFixed(1)}`).join("L");
      add(this.svg, "path", { class: "car", d: `M${d}Z` });
    }
  }

  drawSheave(ends) {
    const { height, radius } = DATA.sheave, [x, y] = this.project([0, height, 0]);
    for (const end of ends) {
      this.line([end[0], end[1] + this.shaft.car.above + this.shaft.car.height, 0], [end[0], height, 0], "head-rope");
    }
    const rx = (Math.abs(ends[0][0]) || radius) * this.scale * this.stretch[0];
    add(this.svg, "ellipse", { class: "sheave", cx: x, cy: y, rx, ry: Math.max(2, radius * this.scale) });
  }

  // mouse and touch: one pointer turns, two or the wheel change the distance; up and down stay the page's on touch
  listen(redraw) {
    const held = new Map();
    const gap = () => {
      const [a, b] = [...held.values()];
      return Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
    };
    this.svg.addEventListener("pointerdown", (event) => {
      held.set(event.pointerId, [event.clientX, event.clientY]);
      this.svg.focus({ preventScroll: true });
    });
    window.addEventListener("pointermove", (event) => {
      const from = held.get(event.pointerId);
      if (!from) return;
      const before = held.size === 2 ? gap() : 0;
      held.set(event.pointerId, [event.clientX, event.clientY]);
      if (held.size === 2) this.zoom(gap() / before);
      else {
        this.turn -= 0.01 * (event.clientX - from[0]);
        this.tilt = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, this.tilt + 0.01 * (event.clientY - from[1])));
      }
      redraw();
    });
    for (const kind of ["pointerup", "pointercancel"]) {
      window.addEventListener(kind, (event) => held.delete(event.pointerId));
    }
    const wheel = (event) => {
      // without a click before it the wheel scrolls the page
      if (document.activeElement !== this.svg) return;
      event.preventDefault();
      this.zoom(Math.exp(-0.0015 * event.deltaY));
      redraw();
    };
    this.svg.addEventListener("wheel", wheel, { passive: false });
  }

  zoom(factor) {
    this.across = Math.min(200, Math.max(0.5, this.across / factor));
  }
}
