// The controls of a log: slider, pause, step, speed.

import { byId, setText } from "./dom.js";

const EVERY_MS = 100;

export class Timeline {
  constructor(order) {
    this.order = order;
    this.panel = byId("timeline");
    this.slider = byId("time");
    this.at = byId("at");
    this.button = byId("play");
    this.speed = byId("speed");
    this.isPlaying = true;
    this.isHeld = false;
    this.button.addEventListener("click", () => this.toggle());
    byId("step-back").addEventListener("click", () => this.send("step", -1));
    byId("step-on").addEventListener("click", () => this.send("step", 1));
    this.slider.addEventListener("input", () => this.seek());
    this.slider.addEventListener("change", () => { this.isHeld = false; });
    this.speed.addEventListener("change", () => this.send("speed", Number(this.speed.value)));
    document.addEventListener("keydown", (event) => this.key(event));
  }

  show(lengthS) {
    this.panel.hidden = false;
    this.slider.max = lengthS;
    this.lengthS = lengthS;
  }

  update(log) {
    this.isPlaying = log.playing;
    setText(this.button, log.playing ? "❚❚" : "▶");
    this.button.setAttribute("aria-label", log.playing ? "pause" : "play");
    if (!this.isHeld && !this.timer) this.place(log.at_s);
    if (document.activeElement !== this.speed) this.speed.value = String(log.speed);
  }

  place(s) {
    this.slider.value = s;
    this.slider.setAttribute("aria-valuetext", `${s.toFixed(2)} s of ${this.lengthS.toFixed(2)} s`);
    setText(this.at, `${s.toFixed(2)} / ${this.lengthS.toFixed(2)} s`);
  }

  toggle() {
    this.send(this.isPlaying ? "pause" : "play");
  }

  // A pending jump comes first.
  send(action, value) {
    if (this.timer) this.jump();
    this.order(action, value);
  }

  jump() {
    clearTimeout(this.timer);
    this.timer = null;
    this.order("seek", this.target);
  }

  // While the slider is dragged the log follows it, not the other way round.
  seek() {
    this.isHeld = true;
    this.target = Number(this.slider.value);
    this.place(this.target);
    this.timer ??= setTimeout(() => this.jump(), EVERY_MS);
  }

  key(event) {
    if (this.panel.hidden || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.closest("button, select, input, [role=button]")) return;
    const action = { " ": () => this.toggle(), ",": () => this.send("step", -1), ".": () => this.send("step", 1) }[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}
