// What linked pages need: dashes, numbers as text, arrays, the page as one picture.

const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3], [14, 5], [5, 5]];
const dash = k => DASHES[k % DASHES.length];
const colour = k => theme("--c" + k);
// Rounding error, next to values of this size, is 0.
const settled = (value, size) => Math.abs(value) < 1e-9 * size ? 0 : value;

// Of values up to a largest one all have its decimals: what changes does not jump, and rounding reads as 0.
function readable(value, largest = NaN) {
  if (Number.isNaN(value)) return "none";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const size = Math.abs(value), decimals = 4 - Math.floor(Math.log10(largest));
  const text = decimals >= 0 && decimals <= 7 ? value.toFixed(decimals).replace(/^-([0.]+)$/, "$1") : size !== 0 && (size < 1e-3 || size >= 1e6) ? value.toExponential(3) : String(+value.toPrecision(5));
  return text.replaceAll("-", "−");
}

// [least, largest] of the finite ones of those numbers.
function extent(arrays, first = 0, last = Infinity) {
  let low = Infinity, high = -Infinity;
  for (const values of arrays)
    for (let k = first; k <= last && k < values.length; k++)
      if (Number.isFinite(values[k])) {
        low = Math.min(low, values[k]);
        high = Math.max(high, values[k]);
      }
  return low <= high ? [low, high] : [0, 1];
}

// The page as one picture on the page's own paper: its scenes with the state, then each plot with title, legend, cursor.
async function savePng(scenes, state, plots) {
  const width = 1100, scale = 2, gap = 14, side = 480, left = side + 2 * gap, room = width - left - gap;
  const box = scenes[0].getBoundingClientRect(), high = side * box.height / box.width;
  const canvas = element("canvas"), pen = canvas.getContext("2d"), font = "13px system-ui, sans-serif";
  pen.font = font;
  const shown = plots.map(plot => {
    const picture = plot.picture(), placed = [];
    let x = 0, row = 0;
    for (const entry of picture.legend) {
      const wide = 33 + Math.min(room - 33, pen.measureText(entry.text).width);
      if (x > 0 && x + wide > room) [x, row] = [0, row + 1];
      placed.push([x, 28 + 18 * row, entry]);
      x += wide + 16;
    }
    const head = 40 + 18 * row;
    return {...picture, placed, head, height: head + picture.canvas.height / picture.canvas.width * room};
  });
  canvas.width = scale * width;
  canvas.height = scale * (50 + gap + Math.max(scenes.length * high + 24, shown.reduce((sum, {height}) => sum + height + gap, 0)));
  pen.scale(scale, scale);
  const write = (text, x, y, most, style = font) => {
    pen.font = style;
    pen.fillStyle = theme("--ink");
    pen.fillText(text, x, y, most);
  };
  const line = (x0, y0, x1, y1, ink, dashes = []) => {
    pen.strokeStyle = ink;
    pen.lineWidth = 2;
    pen.setLineDash(dashes);
    pen.beginPath();
    pen.moveTo(x0, y0);
    pen.lineTo(x1, y1);
    pen.stroke();
  };
  pen.fillStyle = theme("--paper");
  pen.fillRect(0, 0, width, canvas.height);
  write(document.title, gap, 30, width - 2 * gap, "600 18px system-ui, sans-serif");
  for (const [k, scene] of scenes.entries()) {
    const image = new Image(), copy = scene.cloneNode(true);
    for (const [name, value] of [["xmlns", "http://www.w3.org/2000/svg"], ["width", box.width], ["height", box.height]])
      copy.setAttribute(name, value);
    image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(new XMLSerializer().serializeToString(copy));
    await image.decode();
    pen.drawImage(image, gap, 50 + k * high, side, high);
  }
  write(state, gap, 50 + scenes.length * high + 16, side);
  let y = 50;
  for (const {title, placed, head, height, canvas: drawn, frame, cursor} of shown) {
    write(title, left, y + 12, room, "600 14px system-ui, sans-serif");
    for (const [x, down, entry] of placed) {
      if (entry.mark) write(entry.mark, left + x + 11, y + down + 4);
      else line(left + x, y + down, left + x + 28, y + down, entry.colour, entry.dash);
      write(entry.text, left + x + 33, y + down + 4, room - 33);
    }
    const part = room / (drawn.width / devicePixelRatio), top = y + head;
    pen.drawImage(drawn, left, top, room, height - head);
    const [across, down] = cursor, at = (x, y) => [left + part * (frame.left + x), top + part * (frame.top + y)];
    if (across >= 0 && across <= frame.width) line(...at(across, 0), ...at(across, frame.height), cursor.ink);
    if (down >= 0 && down <= frame.height) line(...at(0, down), ...at(frame.width, down), cursor.ink);
    y += height + gap;
  }
  saveCanvas(canvas);
}

function readNotes() {
  byId("notes").append(...content.notes.map(note => element("li", {}, note)));
}
