// The page begins: tabs, the state in the address, themes and sizes.

const tabs = [["five", "Five-bar"], ["four", "Four-bar"], ["slider", "Slider-crank"], ["press", "Press"]].filter(([id]) =>
  id === "five" || typeof showLinkage === "function");
const tabButtons = tabs.map(([id, text]) => element("button", {type: "button", role: "tab", id: `tab-${id}`,
  "aria-selected": "false", "aria-controls": id === "five" ? "five" : "linkage", onclick: () => showTab(id)}, text));
if (tabs.length > 1) byId("tabs").append(...tabButtons); else byId("tabs").remove();

function showTab(id) {
  halt();
  byId("five").hidden = id !== "five";
  byId("linkage").hidden = id === "five";
  tabs.forEach(([own], k) => tabButtons[k].setAttribute("aria-selected", own === id));
  if (id === "five") resized(); else showLinkage(id);
}

function takeFragment() {
  if (location.hash.length < 2) return;
  const {state, words: wrong} = readFragment(location.hash);
  if (wrong) said = `The link's address is not taken: ${wrong}. The robot is as it was.`;
  else {
    halt();
    applyState(state);
    said = "";
  }
}

function resized() {
  if (byId("five").hidden) return;
  fit();
  ask({back: true});
}

function painted() {
  readInks();
  image = null;
  if (field) paintField();
  if (!byId("five").hidden) ask({back: true}); else showLinkage();
}

takeFragment();
byId("five").hidden = false;
readInks();
fit();
survey(true);
showSliders();
modesDrawn = modes.join();
ask({back: true});
dark.addEventListener("change", painted);
new ResizeObserver(oncePerFrame(resized)).observe(task.box);
addEventListener("hashchange", () => {
  if (location.hash === writeFragment()) return;
  takeFragment();
  showSliders();
  survey(true);
  resized();
  moved();
});
requestAnimationFrame(() => requestAnimationFrame(() => { document.body.dataset.ready = "yes"; }));
