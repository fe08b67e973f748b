// The page begins: tabs, the state in the address, themes and sizes.

const tabs = [["five", "Five-bar"], ["four", "Four-bar"], ["slider", "Slider-crank"], ["press", "Press"]];
const tabButtons = tabs.map(([id, text]) => element("button", {type: "button", role: "tab", id: `tab-${id}`,
  "aria-selected": "false", "aria-controls": id === "five" ? "five" : "linkage", onclick: () => showTab(id)}, text));
byId("tabs").append(...tabButtons);

function showTab(id) {
  idle = null;
  halt();
  byId("five").hidden = id !== "five";
  byId("linkage").hidden = id === "five";
  tabs.forEach(([own, text], k) => {
    tabButtons[k].setAttribute("aria-selected", own === id);
    if (own === id) document.title = document.querySelector("h1").textContent = `${text}, live`;
  });
  if (id === "five") resized(); else showLinkage(id);
}

let begun = false;
function takeFragment(hash = location.hash) {
  idle = null;
  const written = hash.length < 2 && !begun ? content.opening : hash;
  const address = written.replace(/%[0-7][0-9a-f]/gi, decodeURIComponent);  // mail programs write + as %2B
  begun = true;
  if (address.length < 2) return;
  const linkage = readLinkage(address);
  if (linkage) return takeLinkage(linkage);
  if (!byId("linkage").hidden) showTab("five");
  const {state, words: wrong} = readFragment(address);
  if (wrong) said = `The link's address is not taken: ${wrong}. The robot is as it was.`;
  else {
    halt();
    applyState(state);
    said = "";
  }
}

function takeLinkage({state, words: wrong}) {
  if (state) {
    const before = {...lab};
    showTab(state.kind.startsWith("slider") ? "slider" : state.kind);
    if (chooseKind(state.kind, state.values, state.branch, wrapped(state.q))) return;
    Object.assign(lab, before);
    if (lab.values) resweep();
    showTab("five");
  }
  said = `The link's address is not taken: ${wrong ?? "those bars never close"}. The robot is as it was.`;
}

function resized() {
  if (!byId("linkage").hidden) { fitBench(); benchFrame(); }
  if (byId("five").hidden) return;
  fit();
  ask({back: true});
}

function painted() {
  readInks();
  if (!byId("five").hidden) ask({back: true}); else showLinkage();
}

byId("five").hidden = false;
tabButtons[0].setAttribute("aria-selected", "true");
readInks();
fit();
survey(true);
takeFragment();
survey(true);
modesDrawn = modes.join();
suggestTorques();
showSliders();
if (location.hash.length < 2 && !content.opening) beginIdle();
ask({back: true});
dark.addEventListener("change", painted);
addEventListener("beforeprint", () => document.documentElement.classList.toggle("from-dark", dark.matches));
const sizes = new ResizeObserver(oncePerFrame(resized));
for (const {box} of [task, bench]) sizes.observe(box);
addEventListener("hashchange", event => {
  const {hash} = new URL(event.newURL);  // the address itself may have been written anew since
  if (hash === writeFragment() || (lab.values && hash === linkageFragment())) return;
  takeFragment(hash);
  showSliders();
  survey(true);
  resized();
  moved();
});
requestAnimationFrame(() => requestAnimationFrame(() => { document.body.dataset.ready = "yes"; }));
