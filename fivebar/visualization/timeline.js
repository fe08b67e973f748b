// The time line of a motion, and its controls: play, slider, clock, link to the moment, speed, over and over.
// A moment has an address, #t=1.77, in seconds: a link to it, and the page that is opened there.

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

function momentInAddress() {
  const text = new URLSearchParams(location.hash.slice(1)).get("t");
  return text ? Number(text) : NaN;
}

class Player {
  // duration and start: s; show(time) draws a moment, counted from the start; text() and words() say the one shown.
  constructor({duration, start = 0, loop = true, show, text, words = text}) {
    Object.assign(this, {duration, start, loop, show, text, words, time: 0, playing: false, last: 0, runs: 0});
    this.button = button("Play", "play", () => this.toggle());
    this.slider = element("input", {id: "time", type: "range", min: 0, max: duration, step: "any", value: 0});
    this.marks = element("div", {id: "marks"});
    this.clock = element("output", {id: "clock", for: "time"});
    this.link = element("a", {id: "moment"}, "Link");
    this.factor = speedChoice(SPEEDS, "speed");
    this.over = button("↻", "play over and over (L)", () => { this.loop = !this.loop; this.update(); });
    Object.assign(this.button, {id: "play"});
    Object.assign(this.factor, {id: "speed"});
    Object.assign(this.over, {id: "loop"});
    this.slider.setAttribute("aria-label", "time");
    this.slider.oninput = () => this.go(+this.slider.value);
  }

  get speed() { return +this.factor.value; }

  controls() {
    const line = element("div", {class: "line"}, this.marks, this.slider);
    return [this.button, line, this.clock, this.link, this.factor, this.over];
  }

  play() {
    if (!this.loop && this.time >= this.duration) this.seek(0);
    this.playing = true;
    this.last = performance.now();
    this.update();
    const run = ++this.runs, next = now => {
      if (!this.playing || run !== this.runs) return;
      this.frame(now);
      requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
  }

  pause() {
    this.playing = false;
    this.update();
  }

  toggle() { if (this.playing) this.pause(); else this.play(); }

  seek(time) {
    this.time = Math.max(0, Math.min(this.duration, time));
    this.show(this.time);
    this.update();
  }

  frame(now) {
    if (!this.playing) return;
    // A page that was out of sight goes on where it was.
    let time = this.time + Math.min(0.5, Math.max(0, now - this.last) / 1000) * this.speed;
    this.last = now;
    if (time > this.duration) {
      if (!this.loop) this.playing = false;
      time = this.loop ? time % this.duration : this.duration;
    }
    this.seek(time);
  }

  faster(by) {
    const next = SPEEDS.indexOf(this.speed) + by;
    if (next in SPEEDS) this.factor.value = SPEEDS[next];
  }

  update() {
    const text = this.text(), name = this.playing ? "Pause" : "Play";
    if (this.button.textContent !== name) {
      this.button.textContent = name;
      this.button.title = name.toLowerCase();
      this.button.setAttribute("aria-label", name.toLowerCase());
    }
    this.over.setAttribute("aria-pressed", this.loop);
    this.slider.value = this.time;
    this.slider.setAttribute("aria-valuetext", this.words());
    if (this.clock.value !== text) this.clock.value = text;
    if (!this.playing) this.address(this.start + this.time);
  }

  // The frame of a notebook has no address of its own.
  address(seconds) {
    this.link.hidden = location.protocol === "about:";
    this.link.href = `#t=${+seconds.toFixed(6)}`;
    this.link.setAttribute("aria-label", `Link to ${+seconds.toFixed(3)} s`);
  }

  // Follow the address; where it names no moment and motion is welcome, play.
  begin(plays) {
    const follow = () => {
      if (!Number.isFinite(momentInAddress())) return;
      this.pause();
      this.seek(momentInAddress() - this.start);
    };
    addEventListener("hashchange", follow);
    this.seek(0);
    follow();
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (plays && !calm && Number.isNaN(momentInAddress())) this.play();
  }

  keys() {
    return {" ": () => this.toggle(), k: () => this.toggle(), l: () => this.over.click(),
      Home: () => this.go(0), End: () => this.go(this.duration)};
  }

  go(time) {
    this.pause();
    this.seek(time);
  }
}
