// Packed numbers, SVG elements and numbers for people; the inverse of packing.py.

const DATA = JSON.parse(document.getElementById("data").textContent);
const TOP = { u8: 254, u16: 65534 };

function unpack(packed) {
  const bytes = Uint8Array.from(atob(packed.data), (c) => c.charCodeAt(0));
  if (packed.kind === "f32") return new Float32Array(bytes.buffer);
  const codes = packed.kind === "u8" ? bytes : new Uint16Array(bytes.buffer);
  const top = TOP[packed.kind], scale = (packed.hi - packed.lo) / top;
  // what rounds to zero is zero: half a step is all that the codes tell
  const near = (q) => (Math.abs(packed.lo + scale * q) <= scale / 2 ? 0 : packed.lo + scale * q);
  return Float64Array.from(codes, (q) => (q > top ? NaN : near(q)));
}

function byId(id) {
  return document.getElementById(id);
}

// an HTML element, or an SVG element inside an SVG parent, with attributes and text
function add(parent, tag, attributes = {}, text = "") {
  const svg = tag === "svg" || parent instanceof SVGElement;
  const element = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (text !== "") element.textContent = text;
  parent.append(element);
  return element;
}

function clear(element) {
  element.replaceChildren();
  return element;
}

// four significant digits, no exponent where four to seven places do
function short(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size < 1e-12) return "0"; // rounding
  if (size >= 1e6 || size < 1e-4) return value.toExponential(2).replace("-", "−").replace("e-", "e−").replace("e+", "e");
  const text = value.toFixed(Math.min(6, Math.max(0, 3 - Math.floor(Math.log10(size)))));
  return text.replace("-", "−");
}

// round numbers between lo and hi, about `count` of them and never a single one, which would tell no scale
function ticks(lo, hi, count) {
  const raw = (hi - lo) / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((k) => k * power >= raw * 0.999) * power;
  const found = [];
  for (let k = Math.ceil(lo / step - 1e-9); k * step <= hi + 1e-9 * step; k++) found.push(k * step);
  return found.length > 1 || !(hi > lo) ? { step, values: found } : ticks(lo, hi, 2 * count);
}

function tickText(value, step) {
  const places = Math.min(6, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
  const digits = Math.floor(Math.log10(Math.abs(value) / step) + 1e-9) + 2; // that tell a tick from the next one
  if (step < 1e-5 && Math.abs(value) >= step / 2 && digits > 4) return value.toPrecision(Math.min(15, digits)).replace("-", "−");
  if (step >= 1e6 || (step < 1e-5 && value !== 0)) return short(value);
  return (Math.abs(value) < step / 2 ? 0 : value).toFixed(places).replace("-", "−");
}

// index k with times[k] <= t < times[k + 1], within the array
function indexBefore(times, t) {
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return t >= times[high] ? high : low;
}
