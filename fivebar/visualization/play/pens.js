// What draws: on a canvas, or into the text of an SVG. Points are in pixels; colours are names of the theme.

let inks = {};
function readInks() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["ink", "quiet", "line", "paper", "raised", "c0", "c1", "c2", "c3", "c4", "c5"])
    inks[name] = style.getPropertyValue("--" + name).trim();
}

class CanvasPen {
  constructor(canvas) { this.canvas = canvas; this.pen = canvas.getContext("2d"); }

  begin(width, height, scale) {
    if (this.canvas.width !== Math.round(width * scale) || this.canvas.height !== Math.round(height * scale)) {
      this.canvas.width = Math.round(width * scale);
      this.canvas.height = Math.round(height * scale);
    }
    this.pen.setTransform(scale, 0, 0, scale, 0, 0);
    this.pen.clearRect(0, 0, width, height);
    this.pen.lineJoin = this.pen.lineCap = "round";
  }

  style({ink, fill, width = 1.5, dash = [], alpha = 1}) {
    this.pen.globalAlpha = alpha;
    if (ink) this.pen.strokeStyle = inks[ink] ?? ink;
    if (fill) this.pen.fillStyle = inks[fill] ?? fill;
    this.pen.lineWidth = width;
    this.pen.setLineDash(dash);
  }

  // several lines [[x, y], ...] at once
  lines(lines, style) {
    this.style(style);
    this.pen.beginPath();
    for (const points of lines) {
      let open = false;
      for (const [x, y] of points) {
        if (open) this.pen.lineTo(x, y); else this.pen.moveTo(x, y);
        open = true;
      }
      if (style.closed) this.pen.closePath();
    }
    if (style.fill) this.pen.fill();
    if (style.ink) this.pen.stroke();
  }

  circle([x, y], radius, style) {
    this.style(style);
    this.pen.beginPath();
    this.pen.arc(x, y, Math.max(radius, 0), 0, TURN);
    if (style.fill) this.pen.fill();
    if (style.ink) this.pen.stroke();
  }

  words(text, [x, y], {ink = "ink", size = 13, align = "left"} = {}) {
    this.style({ink: "paper", fill: ink, width: 4});
    this.pen.font = `600 ${size}px system-ui, sans-serif`;
    this.pen.textAlign = align;
    this.pen.strokeText(text, x, y);
    this.pen.fillText(text, x, y);
  }
}

const escaped = text => text.replace(/[&<>"]/g, letter => `&#${letter.charCodeAt(0)};`);

class SvgPen {
  constructor() { this.parts = []; }

  begin(width, height) { Object.assign(this, {width, height}); }

  look({ink, fill, width = 1.5, dash = [], alpha = 1}) {
    return `stroke="${ink ? inks[ink] ?? ink : "none"}" fill="${fill ? inks[fill] ?? fill : "none"}" ` +
      `stroke-width="${width}" opacity="${alpha}"${dash.length ? ` stroke-dasharray="${dash.join(" ")}"` : ""} ` +
      `stroke-linejoin="round" stroke-linecap="round"`;
  }

  lines(lines, style) {
    const place = x => +x.toFixed(2);
    const path = lines.filter(points => points.length > 1).map(points =>
      "M" + points.map(([x, y]) => `${place(x)} ${place(y)}`).join("L") + (style.closed ? "Z" : "")).join("");
    if (path) this.parts.push(`<path d="${path}" ${this.look(style)}/>`);
  }

  circle([x, y], radius, style) {
    this.parts.push(`<circle cx="${x}" cy="${y}" r="${Math.max(radius, 0)}" ${this.look(style)}/>`);
  }

  words(text, [x, y], {ink = "ink", size = 13, align = "left"} = {}) {
    const anchor = {left: "start", center: "middle", right: "end"}[align];
    this.parts.push(`<text x="${x}" y="${y}" font-family="system-ui, sans-serif" font-weight="600" ` +
      `font-size="${size}" ` +
      `text-anchor="${anchor}" fill="${inks[ink]}">${escaped(text)}</text>`);
  }

  text() {
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${this.width}" height="${this.height}" ` +
      `viewBox="0 0 ${this.width} ${this.height}">\n<rect width="100%" height="100%" fill="${inks.paper}"/>\n` +
      this.parts.join("\n") + "\n</svg>\n";
  }
}

// A plane in pixels: y upwards, as large as it fits.
class View {
  constructor(box, square = false) {
    this.box = box;
    this.square = square;
    this.back = new CanvasPen(element("canvas", {"aria-hidden": "true"}));
    this.front = new CanvasPen(element("canvas", {"aria-hidden": "true"}));
    box.append(this.back.canvas, this.front.canvas);
    this.measure();
  }

  measure() {
    const {width, height} = this.box.getBoundingClientRect();
    [this.width, this.height, this.ratio] = [width, height, Math.min(devicePixelRatio || 1, 2)];
  }

  fit([x0, y0, x1, y1], margin = 22) {
    this.bounds = [x0, y0, x1, y1];
    const room = [this.width, this.height].map(size => Math.max(size - 2 * margin, 10));
    this.scale = Math.min(room[0] / (x1 - x0), room[1] / (y1 - y0));
    this.origin = [this.width / 2 - this.scale * (x0 + x1) / 2, this.height / 2 + this.scale * (y0 + y1) / 2];
  }

  at([x, y]) { return [this.origin[0] + this.scale * x, this.origin[1] - this.scale * y]; }

  from(event) {
    const box = this.box.getBoundingClientRect();
    return [(event.clientX - box.left - this.origin[0]) / this.scale,
      (this.origin[1] - (event.clientY - box.top)) / this.scale];
  }

  begin(pen) { pen.begin(this.width, this.height, this.ratio); }
}

// Save what draw(pen) draws in a view: PNG on the page's own paper at twice the size, or SVG.
function savePicture(view, draw, png) {
  if (!png) {
    const pen = new SvgPen();
    draw(pen);
    return save(new Blob([pen.text()], {type: "image/svg+xml"}), ".svg");
  }
  const made = new CanvasPen(document.createElement("canvas")), {canvas, pen} = made, {ratio} = view;
  view.ratio = 2;
  draw(made);
  view.ratio = ratio;
  Object.assign(pen, {globalCompositeOperation: "destination-over", globalAlpha: 1, fillStyle: inks.paper});
  pen.fillRect(0, 0, view.width, view.height);
  saveCanvas(canvas);
}
