// A plot of numbers over time on a canvas; the legend shows the newest values, or those under the cursor.

import { element, fill, setText } from "./dom.js";
import * as format from "./format.js";

const WINDOW_S = 30;
const MAX_POINTS = 2000;
const N_COLOURS = 6;
const LEFT = 46;
const BOTTOM = 18;
const TOP = 8;
const RIGHT = 8;

export class Plot {
  constructor(canvas, legend) {
    this.canvas = canvas;
    this.legend = legend;
    this.reset();
    canvas.addEventListener("pointermove", (event) => this.point(event.offsetX / canvas.clientWidth));
    canvas.addEventListener("pointerleave", () => this.point(null));
    canvas.addEventListener("blur", () => this.point(null));
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -0.01, ArrowRight: 0.01 }[event.key];
      if (!step) return;
      event.preventDefault();
      this.point(Math.min(1, Math.max(0, (this.cursor ?? 1) + step)));
    });
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  reset() {
    this.series = [];
    this.points = [];
    this.cursor = null;
  }

  get isEmpty() {
    return !this.series.length;
  }

  add(series, points, isReset) {
    if (isReset || series.join("\n") !== this.series.join("\n")) this.points = [];
    this.series = series;
    this.points.push(...points);
    const newest = this.points.at(-1)?.[0] ?? 0;
    const first = this.points.findIndex((point) => point[0] >= newest - WINDOW_S);
    this.points.splice(0, Math.max(first, this.points.length - MAX_POINTS, 0));
    this.draw();
  }

  point(ratio) {
    this.cursor = ratio;
    this.draw();
  }

  draw() {
    const { canvas } = this;
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    if (!width || !height || this.isEmpty) return;
    const scale = window.devicePixelRatio;
    if (canvas.width !== Math.round(width * scale)) canvas.width = Math.round(width * scale);
    if (canvas.height !== Math.round(height * scale)) canvas.height = Math.round(height * scale);
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    const style = getComputedStyle(canvas);
    const colour = (name) => style.getPropertyValue(name);
    pen.font = `11px ${style.fontFamily}`;
    const newest = this.points.at(-1)?.[0] ?? 0;
    const { low, high } = this.range();
    const x = (s) => LEFT + (1 - (newest - s) / WINDOW_S) * (width - LEFT - RIGHT);
    const y = (value) => TOP + (1 - (value - low) / (high - low)) * (height - TOP - BOTTOM);
    this.axes(pen, { x, y, low, high, newest, height, width, colour });
    this.series.forEach((_, index) => {
      pen.strokeStyle = colour(`--series-${index % N_COLOURS}`);
      pen.lineWidth = this.points.length > 1 ? 1.6 : 5;
      pen.lineCap = "round";
      pen.setLineDash(index < N_COLOURS ? [] : [4, 3]);
      pen.beginPath();
      let isDown = false;
      for (const point of this.points) {
        const value = point[index + 1];
        if (value === null) isDown = false;
        else {
          if (!isDown) pen.moveTo(x(point[0]), y(value));
          pen.lineTo(x(point[0]), y(value));
        }
        isDown = value !== null;
      }
      pen.stroke();
    });
    pen.setLineDash([]);
    this.values(pen, { x, newest, width, height, colour });
  }

  range() {
    const values = this.points.flatMap((point) => point.slice(1)).filter((value) => value !== null);
    let low = values.reduce((a, b) => Math.min(a, b), Infinity);
    let high = values.reduce((a, b) => Math.max(a, b), -Infinity);
    if (!(low < Infinity)) [low, high] = [0, 1];
    const margin = high > low ? 0.06 * (high - low) : Math.abs(high) * 0.1 || 1;
    return { low: low - margin, high: high + margin };
  }

  axes(pen, { x, y, low, high, newest, height, width, colour }) {
    pen.strokeStyle = colour("--line");
    pen.fillStyle = colour("--quiet");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of ticks(low, high, 4)) {
      pen.beginPath();
      pen.moveTo(LEFT, y(value));
      pen.lineTo(width - RIGHT, y(value));
      pen.stroke();
      pen.fillText(tick(value), LEFT - 6, y(value));
    }
    pen.textBaseline = "alphabetic";
    for (const ago of [0, 10, 20, 30]) {
      pen.textAlign = ago === 0 ? "right" : ago === WINDOW_S ? "left" : "center";
      pen.fillText(ago ? `−${ago} s` : "newest", x(newest - ago), height - 4);
    }
  }

  // The legend; with the cursor on the plot its values are those of the nearest message.
  values(pen, { x, newest, width, height, colour }) {
    let shown = this.points.at(-1);
    if (this.cursor !== null && this.points.length) {
      const at = newest - (1 - (this.cursor * width - LEFT) / (width - LEFT - RIGHT)) * WINDOW_S;
      shown = this.points.reduce((a, b) => (Math.abs(b[0] - at) < Math.abs(a[0] - at) ? b : a));
      pen.strokeStyle = colour("--ink");
      pen.beginPath();
      pen.moveTo(x(shown[0]), TOP);
      pen.lineTo(x(shown[0]), height - BOTTOM);
      pen.stroke();
    }
    fill(
      this.legend, this.series,
      () => element("li", {}, element("span", { class: "swatch" }), element("span"), element("output")),
      (item, name) => {
        const index = this.series.indexOf(name);
        item.firstElementChild.className = `swatch series-${index % N_COLOURS}`;
        setText(item.children[1], name);
        setText(item.children[2], shown ? format.number(shown[index + 1]) : format.NONE);
      },
    );
  }
}

function ticks(low, high, n) {
  const rough = (high - low) / n;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= rough);
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high && found.length < 20; value += step) found.push(value);
  return found;
}

function tick(value) {
  const size = Math.abs(value);
  if (size < 1e-12) return "0";
  return size >= 1e5 || size < 1e-3 ? value.toExponential(0) : String(Number(value.toPrecision(4)));
}
