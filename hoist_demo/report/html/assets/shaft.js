// The shaft around the rope: lining, floor, dividers, conveyances and head ropes, where they press the rope, its guards.
// Bodies are boxes with rounded edges, as in rope_model/physics/shaft.py: centre, half widths, radius, yaw, and side, -1
// for the lining, which is seen from inside.

const ENDLESS = 1e4; // m, longer than any shaft

class Shaft {
  constructor(data, signal) {
    this.data = data;
    this.signal = signal; // (name, t): a recorded value, NaN where there is none
    this.walled = data.lining.width > 0;
    this.reach = this.walled ? [data.lining.width / 2, data.lining.depth / 2] : [3, 1.5];
  }

  // the conveyance as it is, or a drawing of one
  get car() {
    const { width, depth, height, above } = this.data.conveyance;
    return width > 0 ? { width, depth, height, above, real: true } : { ...CAR, above: 0, real: false };
  }

  boxes(left, right) {
    const { lining, conveyance, head_ropes, dividers, floor } = this.data, found = [];
    if (this.walled) {
      const radius = lining.rounding * Math.min(...this.reach);
      const half = [this.reach[0] - radius, ENDLESS, this.reach[1] - radius];
      found.push({ kind: "lining", centre: [lining.x, 0, lining.z], half, radius, yaw: 0, side: -1 });
    }
    [left, right].forEach(([x, y, z], own) => {
      const { width, depth, height, above } = conveyance, top = y + above + height;
      if (width > 0) {
        const centre = [x, y + above + height / 2, z];
        found.push({ kind: "conveyance", own, centre, half: [width / 2, height / 2, depth / 2], radius: 0, yaw: 0, side: 1 });
      }
      if (head_ropes.diameter > 0) {
        const centre = [x, top + ENDLESS, z], half = [0, ENDLESS, head_ropes.row / 2];
        found.push({ kind: "head_ropes", own, centre, half, radius: head_ropes.diameter / 2, yaw: 0, side: 1 });
      }
    });
    for (const { size, y, offset, direction, rounding } of dividers) {
      const radius = (rounding * size) / 2, half = [size / 2 - radius, size / 2 - radius, ENDLESS];
      const centre = [offset * Math.cos(direction), y, -offset * Math.sin(direction)];
      found.push({ kind: "divider", centre, half, radius, yaw: direction, side: 1 });
    }
    if (floor !== null) {
      const centre = [0, floor - ENDLESS, 0];
      found.push({ kind: "floor", centre, half: [ENDLESS, ENDLESS, ENDLESS], radius: 0, yaw: 0, side: 1 });
    }
    return found;
  }

  // where ropes are pressed now: the drawn point that is nearest to a body of each kind whose force there is
  contacts(t, ropes) {
    const found = [];
    for (const { rope, points, k } of ropes) {
      const boxes = this.boxes(...rope.centres(points)), named = rope.name ? `${rope.name}.` : "";
      for (const kind of new Set(boxes.map((box) => box.kind))) {
        const force = this.signal(`${named}contact.${kind}`, t);
        if (!(force > 0)) continue;
        let best = { distance: Infinity, point: points[0] };
        for (const box of boxes.filter((each) => each.kind === kind)) {
          // a conveyance is what the other leg may come near
          const some = box.own === 0 ? points.slice(k) : box.own === 1 ? points.slice(0, k + 1) : points;
          for (const point of some) {
            const distance = distanceFrom(box, point);
            if (distance < best.distance) best = { distance, point };
          }
        }
        found.push({ kind, force, point: best.point });
      }
    }
    return found;
  }

  draw(view, t, ends, bottom) {
    const low = view.fixed ? view.fixed.low : view.low, high = view.fixed ? ends[0][1] + 1e3 : view.high;
    if (this.walled) this.drawLining(view, Math.max(low, this.data.floor ?? -Infinity), high);
    if (this.data.floor !== null) this.polygon(view, this.ring(this.data.floor), "floor");
    for (const box of this.boxes(...ends)) {
      if (box.kind === "divider") this.drawDivider(view, box);
      if (box.kind === "head_ropes" && !view.fixed) this.drawHeadRopes(view, box, high);
    }
    this.drawGuards(view, t, bottom, ends);
  }

  drawContacts(view, t, ropes) {
    const found = this.contacts(t, ropes);
    for (const { kind, force, point } of found) {
      const [x, y] = view.project(point), words = `${kind.replace("_", " ")} ${short(force)} N`;
      add(view.svg, "circle", { class: "contact", cx: x.toFixed(1), cy: y.toFixed(1), r: view.fixed ? 3 : Math.min(14, 4 + Math.log10(1 + force) * 2).toFixed(1) });
      if (!view.fixed) add(view.svg, "text", { class: "contact-label halo", x: (x + 12).toFixed(1), y: (y + 4).toFixed(1) }, words);
    }
    view.svg.dataset.contacts = found.map(({ kind }) => kind).join(" ");
    const { trip } = this.data;
    const tripped = trip !== null && t >= trip.t;
    view.svg.dataset.tripped = tripped ? trip.cause : "";
    if (tripped && !view.fixed) {
      add(view.svg, "text", { class: "tripped halo", x: 8, y: 16 }, `guard tripped at ${trip.t.toFixed(2)} s: ${trip.cause}`);
    }
  }

  // corners of the lining, or of as much of the ground as is drawn, at a height
  ring(y) {
    const { x, z, rounding } = this.data.lining, [a, b] = this.reach, radius = this.walled ? rounding * Math.min(a, b) : 0;
    const corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]], found = [];
    corners.forEach(([p, q], k) => {
      for (let step = 0; step <= (radius ? 6 : 0); step++) {
        const angle = ((k + step / 6) * Math.PI) / 2;
        const out = radius ? [radius * Math.cos(angle), radius * Math.sin(angle)] : [0, 0];
        found.push([x + p * (a - radius) + out[0], y, z + q * (b - radius) + out[1]]);
      }
    });
    return found;
  }

  drawLining(view, low, high) {
    this.polygon(view, this.ring(low), "lining");
    this.polygon(view, this.ring(high), "lining");
    const top = this.ring(high), from = this.ring(low), edges = this.data.lining.rounding > 0 ? 7 : 1;
    for (let k = 0; k < from.length; k += edges) view.line(from[k], top[k], "lining");
  }

  drawDivider(view, box) {
    const half = box.half[0] + box.radius, long = 1.5 * Math.max(...this.reach);
    const corner = (across, up, along) => {
      const c = Math.cos(box.yaw), s = Math.sin(box.yaw), [x, y, z] = box.centre;
      const [lined, walls] = [across * half, this.reach];
      // from wall to wall, where there are walls
      const least = Math.min(long, walls[1] / Math.max(1e-9, Math.abs(c)), walls[0] / Math.max(1e-9, Math.abs(s)));
      return [x + c * lined + s * along * least, y + up * half, z - s * lined + c * along * least];
    };
    for (const along of [-1, 1]) {
      this.polygon(view, [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => corner(a, b, along)), "divider");
    }
    for (const [a, b] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) view.line(corner(a, b, -1), corner(a, b, 1), "divider");
  }

  drawHeadRopes(view, box, high) {
    const [x, , z] = box.centre, from = box.centre[1] - ENDLESS;
    if (from >= high) return;
    for (const side of [-1, 1]) view.line([x, from, z + side * box.half[2]], [x, high, z + side * box.half[2]], "head-rope");
  }

  // rise: a level; window: a circle about midway between the ends, or about either leg's plumb line at its height
  drawGuards(view, t, bottom, ends) {
    const { rise, rise_y, window, window_y } = this.data.guard, { far } = this.data;
    const middle = [0, 1, 2].map((k) => (ends[0][k] + ends[1][k]) / 2);
    const still = bottom[1] - this.signal("loop.rise", t);
    if (rise > 0) {
      const y = (rise_y > -far ? rise_y : still) + rise;
      if (Number.isFinite(y)) this.polygon(view, this.ring(y), "guard");
    }
    if (window > 0) {
      const fixed = window_y > -far;
      for (const [x, , z] of fixed ? ends : [middle]) {
        const y = fixed ? window_y : bottom[1];
        const circle = Array.from({ length: 24 }, (_, k) => (k * Math.PI) / 12).map((angle) => [x + window * Math.cos(angle), y, z + window * Math.sin(angle)]);
        this.polygon(view, circle, "guard");
      }
    }
  }

  polygon(view, corners, kind) {
    const d = corners.map((corner) => view.project(corner)).map(([u, v]) => `${u.toFixed(1)} ${v.toFixed(1)}`).join("L");
    add(view.svg, "path", { class: kind, d: `M${d}Z` });
  }
}

// of a point from a body's surface, negative within
function distanceFrom({ centre, half, radius, yaw, side }, point) {
  const [x, y, z] = point.map((value, k) => value - centre[k]), c = Math.cos(yaw), s = Math.sin(yaw);
  const q = [c * x - s * z, y, s * x + c * z].map((value, k) => Math.abs(value) - half[k]);
  return side * (Math.hypot(...q.map((value) => Math.max(value, 0))) + Math.min(Math.max(...q), 0) - radius);
}
