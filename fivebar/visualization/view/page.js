// The page of a scene: meshcat's viewer, the legend that shows and hides, and what happens when.

let viewer, fit;

async function unpack(id) {
  const bytes = Uint8Array.from(atob(byId(id).textContent), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

const player = new Player({
  duration: content.duration, start: content.start,
  show(time) {
    viewer.animator.seek(time);
    for (const path of content.bands) {
      const pieces = Math.round(find(path + "/tip").rotation.z * content.pieces);
      find(path + "/band/<object>").geometry.setDrawRange(0, 6 * pieces);
    }
    showEvents(time);
  },
  text: () => (content.start + player.time).toFixed(2) + " s",
});

// What is flashing depends on the time alone, so that it is the same in playing and in dragging.
function showEvents(time) {
  const reach = Math.max(0.2 * player.speed, 0.004 * content.duration);
  const now = {};
  for (const event of content.events)
    if (Math.abs(event.t - time) <= reach) now[event.root] = event;
  for (const root of new Set(content.events.map(event => event.root))) {
    const ring = find(root + "/flash"), event = now[root];
    ring.visible = !!event;
    if (event) ring.position.set(event.place[0], event.place[1], 0);
  }
  const text = Object.values(now).map(event => event.text).join("; ");
  byId("banner").classList.toggle("on", text != "");
  if (text && byId("banner").textContent != text) byId("banner").textContent = text;
}

function find(path) {
  return viewer.scene_tree.find(path.split("/").filter(name => name)).object;
}

function furnish() {
  for (const [low, high] of content.gaps) {
    const gap = element("div", {title: "nothing is known here"});
    gap.style.left = 100 * low / content.duration + "%";
    gap.style.width = Math.max(0.4, 100 * (high - low) / content.duration) + "%";
    player.marks.append(gap);
  }
  for (const event of content.events) {
    const mark = button("", `go to: ${event.text}`, () => player.go(event.t));
    mark.style.left = 100 * event.t / content.duration + "%";
    player.marks.append(mark);
  }
  for (const {key, nodes, ...look} of content.entries) {
    const item = element(nodes.length ? "button" : "span", {class: "entry"}, glyph(look), key);
    byId("key").append(element("li", {}, item));
    if (!nodes.length) continue;
    item.setAttribute("aria-pressed", "true");
    item.title = "show or hide";
    item.onclick = () => {
      const on = item.getAttribute("aria-pressed") != "true";
      item.setAttribute("aria-pressed", on);
      for (const path of nodes) find(path).visible = on;
      viewer.set_dirty();
    };
  }
  for (const [kind, labels] of Object.entries({name: content.labels, sign: content.tips}))
    for (const label of labels) {
      label.element = element("span", {class: kind}, label.text);
      byId("labels").append(label.element);
    }
  const narrow = matchMedia("(max-width: 560px)");  // where many would leave the scene little room, they are folded
  narrow.onchange = () => { byId("fold").open = !narrow.matches || content.entries.length <= 6; };
  narrow.onchange();
  byId("fold").ontoggle = () => dispatchEvent(new Event("resize"));
  byId("controls").append(...player.controls(), button("Fit", "fit the view (F)", () => fit()));
}

// What a line of the key shows: a bar, a line, an area, an arrow, an arrow that turns, in its colours.
const GLYPHS = {
  bar: "M0 2H22V10H0Z", area: "M0 1H22V11H0Z", line: "M0 5H22V7H0Z", arrow: "M0 5H14V2L22 6L14 10V7H0Z",
  turn: "M3 12A8 8 0 0 1 15 4.5L15.500 1L22 6L14 9.500L14.500 6.500A6 6 0 0 0 5.500 12Z",
};
function glyph({glyph: shape, colours}) {
  const made = element("svg", {"aria-hidden": "true", width: 22, height: 12});
  colours.forEach((colour, k) => {
    const path = element("path", {d: GLYPHS[shape]}), share = 100 / colours.length;
    path.style.cssText = `fill: ${colour}; clip-path: inset(0 ${100 - share * (k + 1)}% 0 ${share * k}%)`;
    if (shape == "area") path.style.fillOpacity = 0.3;
    made.append(path);
  });
  return made;
}

onKeys(({shiftKey}) => viewer ? {
  ...player.keys(),
  ArrowLeft: () => player.go(player.time - (shiftKey ? 1 : 1 / 60)),
  ArrowRight: () => player.go(player.time + (shiftKey ? 1 : 1 / 60)),
  f: () => fit(),
  "+": () => player.faster(1),
  "-": () => player.faster(-1),
} : {});

// What draws: a graphics card, the processor in its place, or nothing, where there is no WebGL.
function graphics() {
  const gl = element("canvas").getContext("webgl"), own = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = own ? gl.getParameter(own.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return !gl ? "nothing" : /swiftshader|llvmpipe|software|basic render/i.test(name) ? "processor" : "card";
}

async function begin() {
  document.head.append(element("script", {}, new TextDecoder().decode(await unpack("viewer-gz"))));
  const bytes = await unpack("scene-gz"), lengths = new DataView(bytes.buffer);
  const { Color, Vector3, WebGLRenderer } = MeshCat.THREE, drawnBy = graphics(), flat = drawnBy == "nothing";
  // Opaque, and without a graphics card with plain edges: on the processor both would halve the pictures per second.
  const renderer = flat ? new FlatRenderer() : new WebGLRenderer({ alpha: false, antialias: drawnBy == "card" });
  byId("pane").append(renderer.domElement);
  const made = new MeshCat.Viewer(byId("pane"), true, renderer);
  const resize = made.set_3d_pane_size;
  made.set_3d_pane_size = () => resize.call(made, byId("pane").clientWidth, byId("pane").clientHeight);
  for (let at = 0; at < bytes.length;) {
    const size = lengths.getUint32(at, true);
    made.handle_command_bytearray(bytes.subarray(at + 4, at + 4 + size));
    at += 4 + size;
  }
  made.animator.pause();
  viewer = window.viewer = made;
  if (flat) {
    viewer.controls.enableRotate = false;
    byId("notes").append(element("p", {},
      "This browser has no WebGL here: the motion is drawn flat, and cannot be turned."));
  }
  const camera = viewer.camera, [x, y] = content.half, place = new Vector3();

  function put({element}) {
    place.project(camera);
    element.style.left = (place.x + 1) / 2 * byId("pane").clientWidth + "px";
    element.style.top = (1 - place.y) / 2 * byId("pane").clientHeight + "px";
  }
  function labels() {
    for (const label of content.labels) {
      viewer.scene.localToWorld(place.set(label.x, label.y, 0));
      put(label);
    }
    for (const sign of content.tips) {
      let seen = find(sign.path);
      seen.localToWorld(place.set(...sign.at, 0));
      put(sign);
      let shown = seen.scale.y > sign.least;
      for (; seen; seen = seen.parent) shown &&= seen.visible;
      sign.element.hidden = !shown;
    }
  }
  function distance() {
    const room = 1 - (content.labels.length ? 56 : 8) / Math.max(100, byId("pane").clientHeight);
    return Math.max(y / room, x / camera.aspect / 0.98) / Math.tan(content.field * Math.PI / 360);
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
  const paint = () => {
    renderer.setClearColor(new Color(theme("--paper")), 1);
    viewer.set_dirty();
  };
  dark.addEventListener("change", paint);
  paint();
  paintForPaper();
  const still = element("canvas"), main = byId("pane").parentElement;  // what is printed
  window.addEventListener("beforeprint", () => {
    const {width, height} = renderer.domElement;
    viewer.render();
    Object.assign(still, {width, height});
    still.getContext("2d").drawImage(renderer.domElement, 0, 0);
    main.style.cssText = `width: ${main.clientWidth}px; height: ${main.clientHeight}px`;
    byId("pane").replaceChildren(still);
  });
  window.addEventListener("afterprint", () => {
    main.style.cssText = "";
    byId("pane").replaceChildren(renderer.domElement);
  });
  camera.fov = content.field;
  viewer.controls.addEventListener("change", clip);
  viewer.set_3d_pane_size();
  fit();
  window.addEventListener("resize", () => {
    viewer.set_3d_pane_size();
    camera.position.setLength(distance());
    clip();
  });
  furnish();
  player.begin(true);
  document.body.dataset.ready = "yes";
  (function frame() {
    labels();
    requestAnimationFrame(frame);
  })();
}

begin().catch(error => {
  byId("banner").className = "on failed";
  byId("controls").hidden = true;
  byId("banner").textContent = "This page needs a browser with DecompressionStream: " + error.message;
});
