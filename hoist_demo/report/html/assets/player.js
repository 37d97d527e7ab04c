// The one instant that everything shows: slider, play button, keys and the page's #t=... address.

class Player {
  constructor([start, end]) {
    this.start = start;
    this.end = end;
    this.t = start;
    this.listeners = [];
    this.playing = false;
    this.slider = byId("slider");
    this.slider.min = start;
    this.slider.max = end;
    this.slider.addEventListener("input", () => this.go(Number(this.slider.value)));
    byId("play").addEventListener("click", () => this.toggle());
    document.addEventListener("keydown", (event) => this.key(event));
    window.addEventListener("hashchange", () => this.followAddress());
  }

  onMove(listener) {
    this.listeners.push(listener);
  }

  go(t) {
    this.t = Math.min(this.end, Math.max(this.start, t));
    this.slider.value = this.t;
    byId("clock").textContent = `${this.t.toFixed(2)} s`;
    for (const listener of this.listeners) listener(this.t);
  }

  toggle() {
    this.playing = !this.playing;
    byId("play").textContent = this.playing ? "❚❚" : "▶";
    byId("play").setAttribute("aria-label", this.playing ? "pause" : "play");
    if (!this.playing) return;
    if (this.t >= this.end) this.t = this.start;
    let last = null;
    const step = (now) => {
      if (!this.playing) return;
      // a page in the background gets no frames: do not jump when it comes back
      const passed = last === null ? 0 : Math.min(0.1, (now - last) / 1000);
      last = now;
      this.go(this.t + Number(byId("pace").value) * passed);
      if (this.t >= this.end) this.toggle();
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  key(event) {
    if (["INPUT", "SELECT", "TEXTAREA", "BUTTON", "SUMMARY"].includes(event.target.tagName)) return;
    if (event.key === " ") this.toggle();
    else if (event.key === "ArrowRight") this.go(this.t + 0.1);
    else if (event.key === "ArrowLeft") this.go(this.t - 0.1);
    else return;
    event.preventDefault();
  }

  followAddress() {
    const asked = Number(new URLSearchParams(location.hash.slice(1)).get("t") ?? NaN);
    this.go(Number.isFinite(asked) ? asked : this.t);
  }
}
