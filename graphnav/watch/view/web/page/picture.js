// The picture of the newest message, and the cursor on it.

import { setText } from "./dom.js";
import * as format from "./format.js";

const EVERY_MS = 100;
const STEP = 0.02;

export class Picture {
  // `point` is called with [x, y], fractions of the picture's width and height, or null.
  constructor({ box, canvas, cross, readout }, point) {
    Object.assign(this, { box, canvas, cross, readout });
    this.cursor = null;
    this.point = throttled(point);
    canvas.addEventListener("pointermove", (event) => this.move(this.within(event)));
    canvas.addEventListener("pointerdown", (event) => this.move(this.within(event)));
    canvas.addEventListener("pointerleave", () => this.move(null));
    canvas.addEventListener("blur", () => this.move(null));
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] }[event.key];
      if (!step) return;
      event.preventDefault();
      this.move((this.cursor ?? [0.5, 0.5]).map((place, axis) => Math.min(0.999, Math.max(0, place + step[axis]))));
    });
  }

  async show(blob) {
    const bitmap = await createImageBitmap(blob);
    if (this.canvas.width !== bitmap.width) this.canvas.width = bitmap.width;
    if (this.canvas.height !== bitmap.height) this.canvas.height = bitmap.height;
    this.canvas.getContext("2d").drawImage(bitmap, 0, 0);
    bitmap.close();
    this.box.hidden = this.readout.hidden = false;
    this.mark();
  }

  hide() {
    this.box.hidden = this.readout.hidden = true;
    this.cursor = null;
  }

  // `hasCells`: whether a position on the picture is a cell of the message's arrays.
  say(hasCells, under) {
    if (!under) {
      const hint = this.cursor ? "no value here" : "point at the picture to read its values";
      setText(this.readout, hasCells ? hint : "\u00a0");
      return;
    }
    const values = Object.entries(under.values).map(([name, list]) => `${name} ${list.map(format.number).join(", ")}`);
    setText(this.readout, [`x ${under.x_px}, y ${under.y_px} px`, ...values].join("  ·  "));
  }

  // The rectangle of the picture within the canvas, with its aspect ratio.
  place() {
    const { clientWidth, clientHeight, width, height } = this.canvas;
    const scale = Math.min(clientWidth / width, clientHeight / height);
    const [w, h] = [width * scale, height * scale];
    return { left: (clientWidth - w) / 2, top: (clientHeight - h) / 2, w, h };
  }

  within(event) {
    const { left, top, w, h } = this.place();
    const at = [(event.offsetX - left) / w, (event.offsetY - top) / h];
    return at.every((place) => place >= 0 && place < 1) ? at : null;
  }

  move(cursor) {
    if (cursor === this.cursor) return;
    this.cursor = cursor;
    this.mark();
    this.point(cursor);
  }

  mark() {
    this.cross.hidden = !this.cursor;
    if (!this.cursor) return;
    const { left, top, w, h } = this.place();
    this.cross.style.left = `${this.canvas.offsetLeft + left + this.cursor[0] * w}px`;
    this.cross.style.top = `${this.canvas.offsetTop + top + this.cursor[1] * h}px`;
  }
}

function throttled(call) {
  let timer = null;
  let newest;
  return (value) => {
    newest = value;
    timer ??= setTimeout(() => {
      timer = null;
      call(newest);
    }, EVERY_MS);
  };
}
