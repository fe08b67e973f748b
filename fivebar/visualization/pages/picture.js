// The mechanism in the plane, in pixels: strokes are as wide on the screen at any zoom, and joints are round in every
// browser. Paths have no more points than are seen: a browser takes seconds for a stroke of ten thousand.

class Picture {
  constructor(parent, bounds, name) {
    this.bounds = bounds;
    this.zoom = 1;
    this.parts = [];
    this.curves = [];
    this.mechanisms = [];
    this.svg = element("svg", {class: "scene", role: "img", "aria-label": `the mechanism: ${name}`});
    const [x0, y0, x1, y1] = bounds, room = 0.2 * Math.max(x1 - x0, y1 - y0);
    this.svg.style.aspectRatio = (x1 - x0 + room) / (y1 - y0 + room);
    this.world = element("g", {fill: "none", "stroke-linecap": "round", "stroke-linejoin": "round"});
    this.paths = element("g", {fill: "none", "stroke-linecap": "round", "stroke-linejoin": "round"});
    this.letters = element("g", {"font-family": "system-ui, sans-serif", "font-size": 14, "font-weight": 600,
      "stroke-width": 4, "stroke-linejoin": "round", "paint-order": "stroke"});
    this.rule = element("path", {fill: "none", "stroke-width": 2});
    this.length = element("text", {"font-family": "system-ui, sans-serif", "font-size": 12});
    this.svg.append(this.paths, this.world, this.letters, this.rule, this.length);
    parent.append(this.svg);
    new ResizeObserver(() => this.fit()).observe(this.svg);
  }

  // A stroke whose colour is a name of the theme.
  stroke(tag, parent, ink, width, attributes = {}) {
    const part = element(tag, {"stroke-width": width, ...attributes});
    this.parts.push([part, ink]);
    parent.append(part);
    return part;
  }

  path(xs, ys, ink, width, dashes = [], attributes = {}) {
    const line = this.stroke("path", this.paths, ink, width, {"stroke-dasharray": dashes.join(" "), ...attributes});
    this.curves.push({xs, ys, line});
  }

  trace({xs, ys, line}) {
    const {width, height} = this, [x0, y0] = this.origin;
    const apart = (a, b, limit) => Math.max(a, b) < 0 || Math.min(a, b) > limit;
    let d = "", px = NaN, py = NaN, pen = false;  // the last point that counts, and whether the pen is there
    for (let k = 0; k < xs.length; k++) {
      const x = x0 + this.scale * xs[k], y = y0 - this.scale * ys[k];
      if (!(Number.isFinite(x) && Number.isFinite(y))) pen = false;
      else if (Math.abs(x - px) + Math.abs(y - py) < 1 && k < xs.length - 1) continue;
      else if (Number.isNaN(px) || apart(px, x, width) || apart(py, y, height)) pen = false;
      else {
        d += `${pen ? "" : `M${px.toFixed(2)} ${py.toFixed(2)}`}L${x.toFixed(2)} ${y.toFixed(2)}`;
        pen = true;
      }
      [px, py] = [x, y];
    }
    line.setAttribute("d", d);
  }

  // A mechanism of bars [i, j, colour name], placed by `place`.
  mechanism({bars, pins, grounded, actuated, traced, rails = [], blocks = [], letters = [], opacity = 1, name = "",
    mark = "round"}) {
    const group = element("g", {opacity, class: "mechanism", "data-name": name});
    this.world.append(group);
    const line = (ends, ink, width, attributes) =>
      [...ends, this.stroke("line", group, ink, width, attributes)];
    const lines = [
      ...rails.map(ends => line(ends, "--line", 6, {class: "rail"})),
      ...grounded.map(k => line([k, k], "--quiet", 20, {"stroke-linecap": "square", class: "ground"})),
      ...blocks.map(ends => line(ends, "--quiet", 18, {"stroke-linecap": "butt", class: "block"})),
      ...bars.map(([i, j, ink]) => line([i, j], ink, 7, {class: "bar"})),
      ...actuated.map(k => line([k, k], "--ink", 17, {class: "motor"})),
      ...pins.map(k => line([k, k], "--ink", 11, {class: "joint"})),
      ...pins.map(k => line([k, k], k === traced ? "--c4" : "--paper", 6, {"stroke-linecap": mark})),
    ];
    const texts = letters.map((text, k) => [k, element("text", {}, text)]).filter(([, made]) => made.textContent);
    this.letters.append(...texts.map(([, made]) => made));
    const made = {group, lines, texts, points: []};
    this.mechanisms.push(made);
    return made;
  }

  // Points [[x, y], ...] in metres; where one is not finite the mechanism is not seen.
  place(mechanism, points) {
    const good = points.every(point => point.every(Number.isFinite));
    mechanism.group.setAttribute("visibility", good ? "visible" : "hidden");
    mechanism.points = good ? points : [];
    this.draw(mechanism);
    return good;
  }

  draw({lines, texts, points}) {
    for (const [, text] of texts) text.setAttribute("visibility", points.length ? "visible" : "hidden");
    if (!points.length || !this.origin) return;
    const on = points.map(point => this.onScreen(point));
    for (const [i, j, line] of lines) {
      line.setAttribute("x1", on[i][0]);
      line.setAttribute("y1", on[i][1]);
      line.setAttribute("x2", on[j][0]);
      line.setAttribute("y2", on[j][1]);
    }
    for (const [k, text] of texts) {
      text.setAttribute("x", on[k][0] + 11);
      text.setAttribute("y", on[k][1] - 10);
    }
  }

  // Zoomed in, `centre` is in the middle of the picture; at zoom 1 all is seen.
  fit(centre = this.centre) {
    const {width, height} = this.svg.getBoundingClientRect(), [x0, y0, x1, y1] = this.bounds;
    if (!width || !height) return;
    Object.assign(this, {width, height, centre});
    const margin = Math.min(34, width / 4, height / 4), above = height - Math.min(16, height / 8);  // the rule
    const whole = Math.min((width - 2 * margin) / (x1 - x0), (above - 2 * margin) / (y1 - y0));
    this.scale = whole * this.zoom;
    const [x, y] = this.zoom > 1 && centre ? centre : [(x0 + x1) / 2, (y0 + y1) / 2];
    this.origin = [width / 2 - this.scale * x, above / 2 + this.scale * y];
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    for (const curve of this.curves) this.trace(curve);
    for (const mechanism of this.mechanisms) this.draw(mechanism);
    const {length, text} = scaleBar(0.3 * width / this.scale);
    this.rule.setAttribute("d", `M12 ${height - 18}v6h${this.scale * length}v-6`);
    this.length.setAttribute("x", 16);
    this.length.setAttribute("y", height - 18);
    this.length.textContent = text;
  }

  onScreen([x, y]) {
    return [this.origin[0] + this.scale * x, this.origin[1] - this.scale * y];
  }

  paint() {
    for (const [part, ink] of this.parts) part.setAttribute("stroke", ink.startsWith("#") ? ink : theme(ink));
    this.letters.setAttribute("fill", theme("--ink"));
    this.letters.setAttribute("stroke", theme("--paper"));
    this.length.setAttribute("fill", theme("--quiet"));
    this.rule.setAttribute("stroke", theme("--quiet"));
  }
}

// Bounds of points and paths in the plane, with room for a mechanism that stays in one place.
function around(xs, ys) {
  const [x0, x1] = extent(xs), [y0, y1] = extent(ys), room = Math.max(x1 - x0, y1 - y0) > 0 ? 0 : 0.5;
  return [x0 - room, y0 - room, x1 + room, y1 + room];
}
