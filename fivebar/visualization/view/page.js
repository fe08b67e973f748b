"use strict";
const $ = id => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
let viewer, fit;

async function unpack(id) {
  const bytes = Uint8Array.from(atob($(id).textContent), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

const player = {
  time: 0, playing: false, speed: 1, loop: true, last: 0,
  play() {
    if (!this.loop && this.time >= data.duration) this.seek(0);
    this.playing = true;
    this.last = performance.now();
    this.show();
  },
  pause() { this.playing = false; this.show(); },
  toggle() { this.playing ? this.pause() : this.play(); },
  seek(time) {
    this.time = Math.max(0, Math.min(data.duration, time));
    viewer.animator.seek(this.time);
    for (const path of data.bands) {
      const pieces = Math.round(find(path + "/tip").rotation.z * data.pieces);
      find(path + "/band/<object>").geometry.setDrawRange(0, 6 * pieces);
    }
    this.show();
  },
  frame(now) {
    if (!this.playing) return;
    // A page that was out of sight goes on where it was.
    let time = this.time + Math.min(0.5, Math.max(0, now - this.last) / 1000) * this.speed;
    this.last = now;
    if (time > data.duration) {
      if (!this.loop) this.playing = false;
      time = this.loop ? time % data.duration : data.duration;
    }
    this.seek(time);
  },
  show() {
    const clock = (data.start + this.time).toFixed(2) + " s";
    $("play").textContent = this.playing ? "pause" : "play";
    $("loop").setAttribute("aria-pressed", this.loop);
    $("time").value = this.time;
    $("time").setAttribute("aria-valuetext", clock);
    if ($("clock").value != clock) $("clock").value = clock;
    if (!this.playing) pointTo($("moment"), data.start + this.time);
    showEvents();
  },
};

// What is flashing depends on the time alone, so that it is the same in playing and in dragging.
function showEvents() {
  const reach = Math.max(0.2 * player.speed, 0.004 * data.duration);
  const now = {};
  for (const event of data.events)
    if (Math.abs(event.t - player.time) <= reach) now[event.root] = event;
  for (const root of new Set(data.events.map(event => event.root))) {
    const ring = find(root + "/flash"), event = now[root];
    ring.visible = !!event;
    if (event) ring.position.set(event.place[0], event.place[1], 0);
  }
  const text = Object.values(now).map(event => event.text).join("; ");
  $("banner").classList.toggle("on", text != "");
  if (text && $("banner").textContent != text) $("banner").textContent = text;
}

function find(path) {
  return viewer.scene_tree.find(path.split("/").filter(name => name)).object;
}

function furnish() {
  $("time").max = data.duration;
  document.body.style.setProperty("--shape", data.half[0] / data.half[1]);
  for (const factor of SPEEDS) $("speed").add(new Option(factor + " ×", factor, false, factor == 1));
  for (const [low, high] of data.gaps) {
    const gap = document.createElement("div");
    gap.style.left = 100 * low / data.duration + "%";
    gap.style.width = Math.max(0.4, 100 * (high - low) / data.duration) + "%";
    gap.title = "nothing is known here";
    $("marks").append(gap);
  }
  for (const event of data.events) {
    const mark = document.createElement("button");
    mark.style.left = 100 * event.t / data.duration + "%";
    mark.title = event.text;
    mark.setAttribute("aria-label", "go to: " + event.text);
    mark.onclick = () => { player.pause(); player.seek(event.t); };
    $("marks").append(mark);
  }
  for (const entry of data.entries) {
    const item = document.createElement(entry.nodes.length ? "button" : "span");
    item.append(swatch(entry), entry.key);
    $("key").append(item);
    if (!entry.nodes.length) continue;
    item.setAttribute("aria-pressed", "true");
    item.title = "show or hide";
    item.onclick = () => {
      const on = item.getAttribute("aria-pressed") != "true";
      item.setAttribute("aria-pressed", on);
      for (const path of entry.nodes) find(path).visible = on;
      viewer.set_dirty();
    };
  }
  for (const [kind, labels] of Object.entries({name: data.labels, sign: data.tips}))
    for (const label of labels) {
      label.element = document.createElement("span");
      label.element.className = kind;
      label.element.textContent = label.text;
      $("labels").append(label.element);
    }
  const narrow = matchMedia("(max-width: 560px)");  // where many would leave the scene little room, they are folded
  narrow.onchange = () => { $("fold").open = !narrow.matches || data.entries.length <= 6; };
  narrow.onchange();
  $("fold").ontoggle = () => dispatchEvent(new Event("resize"));
  $("play").onclick = () => player.toggle();
  $("time").oninput = () => player.seek(+$("time").value);
  $("speed").onchange = () => { player.speed = +$("speed").value; };
  $("loop").onclick = () => { player.loop = !player.loop; player.show(); };
  $("fit").onclick = () => fit();
}

// What a line of the key shows: a bar, a line, an area, an arrow, an arrow that turns, in its colours.
const GLYPHS = {
  bar: "M0 2H22V10H0Z", area: "M0 1H22V11H0Z", line: "M0 5H22V7H0Z", arrow: "M0 5H14V2L22 6L14 10V7H0Z",
  turn: "M3 12A8 8 0 0 1 15 4.5L15.500 1L22 6L14 9.500L14.500 6.500A6 6 0 0 0 5.500 12Z",
};
function swatch({glyph, colours}) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("aria-hidden", "true");
  colours.forEach((colour, k) => {
    const path = document.createElementNS(svg.namespaceURI, "path"), share = 100 / colours.length;
    path.setAttribute("d", GLYPHS[glyph]);
    path.style.cssText = `fill: ${colour}; clip-path: inset(0 ${100 - share * (k + 1)}% 0 ${share * k}%)`;
    if (glyph == "area") path.style.fillOpacity = 0.3;
    svg.append(path);
  });
  return svg;
}

const KEYS = {
  " ": () => player.toggle(),
  k: () => player.toggle(),
  ArrowLeft: shift => step(shift ? -1 : -1 / 60),
  ArrowRight: shift => step(shift ? 1 : 1 / 60),
  Home: () => player.seek(0),
  End: () => step(data.duration),
  l: () => $("loop").click(),
  f: () => fit(),
  "+": () => faster(1),
  "-": () => faster(-1),
};

function step(seconds) {
  player.pause();
  player.seek(player.time + seconds);
}

function faster(by) {
  const next = SPEEDS.indexOf(player.speed) + by;
  if (next in SPEEDS) $("speed").value = player.speed = SPEEDS[next];
}

document.addEventListener("keydown", event => {
  const key = event.key.length == 1 ? event.key.toLowerCase() : event.key;
  const own = event.target.tagName;
  if (!viewer || !(key in KEYS) || event.ctrlKey || event.metaKey || event.altKey || own == "SELECT") return;
  if (key == " " && own == "BUTTON" && event.target.id != "play") return;
  event.preventDefault();
  KEYS[key](event.shiftKey);
});
// A button takes the space bar when it is let go: on `play` the key has been handled already.
$("play").addEventListener("keyup", event => { if (event.key == " ") event.preventDefault(); });

// What draws: a graphics card, the processor in its place, or nothing, where there is no WebGL.
function graphics() {
  const gl = document.createElement("canvas").getContext("webgl"), own = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = own ? gl.getParameter(own.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return !gl ? "nothing" : /swiftshader|llvmpipe|software|basic render/i.test(name) ? "processor" : "card";
}

async function begin() {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await unpack("viewer-gz"));
  document.head.append(script);
  const bytes = await unpack("scene-gz"), lengths = new DataView(bytes.buffer);
  const { Color, Vector3, WebGLRenderer } = MeshCat.THREE, drawnBy = graphics(), flat = drawnBy == "nothing";
  // Opaque, and without a graphics card with plain edges: on the processor both would halve the pictures per second.
  const renderer = flat ? new FlatRenderer() : new WebGLRenderer({ alpha: false, antialias: drawnBy == "card" });
  $("pane").append(renderer.domElement);
  const made = new MeshCat.Viewer($("pane"), true, renderer);
  const resize = made.set_3d_pane_size;
  made.set_3d_pane_size = () => resize.call(made, $("pane").clientWidth, $("pane").clientHeight);
  for (let at = 0; at < bytes.length;) {
    const size = lengths.getUint32(at, true);
    made.handle_command_bytearray(bytes.subarray(at + 4, at + 4 + size));
    at += 4 + size;
  }
  made.animator.pause();
  viewer = window.viewer = made;
  if (flat) {
    viewer.controls.enableRotate = false;
    const note = document.createElement("p");
    note.textContent = "This browser has no WebGL here: the motion is drawn flat, and cannot be turned.";
    $("notes").append(note);
  }
  const camera = viewer.camera, [x, y] = data.half, place = new Vector3();

  function put({element}) {
    place.project(camera);
    element.style.left = (place.x + 1) / 2 * $("pane").clientWidth + "px";
    element.style.top = (1 - place.y) / 2 * $("pane").clientHeight + "px";
  }
  function labels() {
    for (const label of data.labels) {
      viewer.scene.localToWorld(place.set(label.x, label.y, 0));
      put(label);
    }
    for (const sign of data.tips) {
      let seen = find(sign.path);
      seen.localToWorld(place.set(...sign.at, 0));
      put(sign);
      let shown = seen.scale.y > sign.least;
      for (; seen; seen = seen.parent) shown &&= seen.visible;
      sign.element.hidden = !shown;
    }
  }
  function distance() {
    const room = 1 - (data.labels.length ? 56 : 8) / Math.max(100, $("pane").clientHeight);
    return Math.max(y / room, x / camera.aspect / 0.98) / Math.tan(data.field * Math.PI / 360);
  }
  function clip() {  // close about the scene, or a line would not be told from what it lies on
    camera.near = Math.max(0.01, camera.position.length() - 2);
    camera.far = camera.position.length() + 3;
    viewer.set_dirty();
  }
  fit = () => {
    viewer.controls.target.set(0, 0, 0);
    camera.up.set(0, 1, 0);
    camera.position.set(0, distance(), 1e-4);
    viewer.controls.update();
    clip();
    viewer.set_dirty();
  };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.onchange = () => {
    renderer.setClearColor(new Color(getComputedStyle(document.body).backgroundColor), 1);
    viewer.set_dirty();
  };
  dark.onchange();
  const still = document.createElement("canvas"), main = $("pane").parentElement;  // what is printed
  window.addEventListener("beforeprint", () => {
    const {width, height} = renderer.domElement;
    document.documentElement.classList.add("printed");
    dark.onchange();
    viewer.render();
    Object.assign(still, {width, height});
    still.getContext("2d").drawImage(renderer.domElement, 0, 0);
    main.style.cssText = `width: ${main.clientWidth}px; height: ${main.clientHeight}px`;
    $("pane").replaceChildren(still);
  });
  window.addEventListener("afterprint", () => {
    document.documentElement.classList.remove("printed");
    main.style.cssText = "";
    $("pane").replaceChildren(renderer.domElement);
    dark.onchange();
  });
  camera.fov = data.field;
  viewer.controls.addEventListener("change", clip);
  viewer.set_3d_pane_size();
  fit();
  window.addEventListener("resize", () => {
    viewer.set_3d_pane_size();
    camera.position.setLength(distance());
    clip();
  });
  furnish();
  player.seek(0);
  follow(t => { player.pause(); player.seek(t - data.start); });
  document.body.dataset.ready = "yes";
  if (Number.isNaN(momentInAddress()) && !matchMedia("(prefers-reduced-motion: reduce)").matches) player.play();
  (function frame(now) {
    player.frame(now);
    labels();
    requestAnimationFrame(frame);
  })(performance.now());
}

begin().catch(error => {
  $("banner").className = "on failed";
  $("controls").hidden = true;
  $("banner").textContent = "This page needs a browser with DecompressionStream: " + error.message;
});
