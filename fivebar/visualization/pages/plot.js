// A plot: Bokeh draws axes and curves, a pane of glass over its frame takes the pointer and holds the cursor.

// What plots see along one axis; each of Bokeh's documents needs a range of its own, so these follow.
class Range {
  constructor([start, end] = [0, 1]) {
    this.followers = [];
    this.set(start, end);
  }

  set(start, end) {
    this.start = start;
    this.end = end;
    for (const range of this.followers) range.setv({start, end});
  }

  follower() {
    const range = new Bokeh.Range1d({start: this.start, end: this.end});
    this.followers.push(range);
    return range;
  }
}

paintForPaper();

const FONT = "system-ui, sans-serif";

class Plot {
  constructor(parent, options, ranges) {
    this.ranges = ranges;
    this.element = element("div", {class: "plot", role: "img"});
    this.cursor = element("div", {class: "cursor"});
    this.glass = element("div", {class: "glass"}, this.cursor);
    parent.append(this.element);
    this.figure = Bokeh.Plotting.figure({
      sizing_mode: "stretch_width", x_range: ranges.x.follower(), y_range: ranges.y.follower(), tools: "",
      toolbar_location: null, border_fill_color: null, background_fill_color: null, outline_line_color: null,
      output_backend: "canvas", ...options,
    });
  }

  // Curves of typed arrays, Bokeh's own glyphs; `data_source.data` gets what is seen.
  curve(kind, k, options = {}) {
    const source = new Bokeh.ColumnDataSource({data: {x: [], y: []}});
    const place = {x: {field: "x"}, y: {field: "y"}, source};
    return this.figure[kind]({...place, line_dash: dash(k), line_join: "round", ...options});
  }

  async show(changed) {
    this.view = await Bokeh.Plotting.show(this.figure, this.element);
    this.view.el.inert = true;  // its own focus has no name and no use: keys are the page's
    this.element.append(this.glass);
    addEventListener("beforeprint", () => {  // what has been painted just now would be drawn too late
      for (const own of this.figure.renderers) this.view.views.find_one(own).set_visuals();
      const still = this.view.export("png", true).canvas, pen = still.getContext("2d"), {ink} = this.pointed();
      const {left, top, width, height} = this.view.frame.bbox, [across, down] = this.pointed();
      const zoom = still.width / this.view.el.clientWidth;
      pen.setTransform(zoom, 0, 0, zoom, 0, 0);
      pen.fillStyle = ink;
      const wide = down === undefined ? 2 : 1;
      if (across >= 0 && across <= width) pen.fillRect(left + across - wide / 2, top, wide, height);
      if (down >= 0 && down <= height) pen.fillRect(left, top + down - wide / 2, width, wide);
      pen.globalCompositeOperation = "destination-over";  // or a PDF of Firefox has lines in grey
      pen.fillStyle = theme("--paper");
      pen.fillRect(0, 0, still.width, still.height);
      still.className = "still";
      still.style.width = `${this.view.el.clientWidth}px`;
      this.glass.before(still);
    });
    addEventListener("afterprint", () => this.element.querySelector(".still")?.remove());
    this.figure.properties.inner_width.change.connect(changed);
    this.figure.properties.inner_height.change.connect(changed);
  }

  layGlass() {
    if (!this.view) return;  // another plot of the page was shown first
    const {left, top, width, height} = this.view.frame.bbox;
    Object.assign(this.glass.style, {left: left + "px", top: top + "px", width: width + "px", height: height + "px"});
  }

  // Where an event is in the plot, as a share of its frame from the left, and from the bottom.
  share(event) {
    const box = this.glass.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height];
  }

  at(event) {
    const [x, y] = this.share(event), inside = (range, share) => range.start + share * (range.end - range.start);
    return [inside(this.ranges.x, x), inside(this.ranges.y, y)];
  }

  // Pixels from the frame's left and top.
  pixels(x, y = 0) {
    const {width, height} = this.view.frame.bbox, {x: across, y: up} = this.ranges;
    return [width * (x - across.start) / (across.end - across.start),
            height * (1 - (y - up.start) / (up.end - up.start))];
  }

  paint() {
    const ink = theme("--ink"), quiet = theme("--quiet"), figure = this.figure;
    for (const axis of [...figure.xaxes, ...figure.yaxes])
      axis.setv({axis_line_color: quiet, major_tick_line_color: quiet, minor_tick_line_color: null,
        major_label_text_color: ink, axis_label_text_color: ink, axis_label_text_font_style: "normal",
        major_label_text_font_size: "12px", axis_label_text_font_size: "13px", major_label_text_font: FONT,
        axis_label_text_font: FONT});
    for (const grid of [...figure.xgrids, ...figure.ygrids]) grid.setv({grid_line_color: theme("--grid")});
  }

  // For savePng; `pointed` gives the cursor's place in the frame, px from its left and top (or none), and its ink.
  picture() {
    const {left, top, width, height} = this.view.frame.bbox;
    return {title: this.title, legend: this.legend(), cursor: this.pointed(), frame: {left, top, width, height},
      canvas: this.view.export("png", true).canvas};
  }
}

// Samples first to last, of so many that each of 500 columns keeps its least and largest (and a gap, if it has one):
// a browser takes seconds for lines through ten thousand points.
function seen(xs, ys, first, last) {
  const columns = 500, count = last - first + 1, kept = [];
  if (count <= 4 * columns) return {x: xs.subarray(first, last + 1), y: ys.subarray(first, last + 1)};
  for (let column = 0; column < columns; column++) {
    const from = first + Math.floor(column * count / columns), to = first + Math.floor((column + 1) * count / columns);
    let low = -1, high = -1, gap = -1;
    for (let k = from; k < to; k++)
      if (!Number.isFinite(ys[k])) gap = k;
      else {
        if (low < 0 || ys[k] < ys[low]) low = k;
        if (high < 0 || ys[k] > ys[high]) high = k;
      }
    kept.push(...[...new Set([low, high, gap])].filter(k => k >= 0).sort((a, b) => a - b));
  }
  kept.push(last);
  return {x: Float64Array.from(kept, k => xs[k]), y: Float64Array.from(kept, k => ys[k])};
}

function zoomed(range, factor, about, whole, finest) {
  const least = finest * (whole[1] - whole[0]);
  const width = Math.min(Math.max((range.end - range.start) * factor, least), whole[1] - whole[0]);
  const share = (about - range.start) / (range.end - range.start);
  const start = Math.min(Math.max(about - share * width, whole[0]), whole[1] - width);
  range.set(start, start + width);
}
