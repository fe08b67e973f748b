// A moment of a motion has an address, #t=1.77, in seconds: a link to it, and the page that is opened there.

function momentInAddress() {
  const text = new URLSearchParams(location.hash.slice(1)).get("t");
  return text ? Number(text) : NaN;
}

// The frame of a notebook has no address of its own.
function pointTo(link, seconds) {
  link.hidden = location.protocol === "about:";
  link.href = `#t=${+seconds.toFixed(6)}`;
  link.setAttribute("aria-label", `Link to ${+seconds.toFixed(3)} s`);
}

function follow(show) {
  const go = () => { if (Number.isFinite(momentInAddress())) show(momentInAddress()); };
  addEventListener("hashchange", go);
  go();
}
