// The map in top view, with the robot and its path, in metres: x to the right, y up.

import { setText, svg } from "./dom.js";

const MARGIN_M = 0.3;
const MOVED = ["moving", "seen"];

export class Floor {
  constructor({ box, readout, empty }) {
    Object.assign(this, { box, readout, empty });
    this.world = null;
    this.points = [];
    this.track = null;
    this.root = svg("svg", { class: "floor", role: "img", "aria-label": "map", preserveAspectRatio: "xMidYMid meet" });
    this.root.addEventListener("pointermove", (event) => this.point(event));
    this.root.addEventListener("pointerleave", () => {
      this.at = null;
      this.say();
    });
    box.append(this.root);
    this.draw();
  }

  reset() {
    this.world = this.track = this.at = null;
    this.points = [];
    this.draw();
  }

  update(world, track) {
    if (world !== undefined) this.world = world;
    if (track) {
      this.points = track.reset ? track.points : this.points.concat(track.points);
      this.track = track;
    }
    if (world !== undefined || !this.path || track?.reset || this.isOutside()) this.draw();
    else this.moveRobot();
    this.say();
  }

  draw() {
    const areas = this.world?.areas ?? [];
    const all = [...this.points, ...(this.track ? [this.track.pose] : [])];
    for (const area of areas) if (area && !MOVED.includes(area.role)) all.push(...area.outline);
    this.empty.hidden = all.length > 0;
    this.box.hidden = !all.length;
    this.root.replaceChildren();
    this.path = null;
    if (!all.length) return;
    const [xs, ys] = [0, 1].map((axis) => all.map((point) => point[axis]));
    const extent = (list, pick) => list.reduce((a, b) => pick(a, b));
    this.low = [extent(xs, Math.min) - MARGIN_M, extent(ys, Math.min) - MARGIN_M];
    this.high = [extent(xs, Math.max) + MARGIN_M, extent(ys, Math.max) + MARGIN_M];
    const [width, height] = [0, 1].map((axis) => this.high[axis] - this.low[axis]);
    this.root.setAttribute("viewBox", `${this.low[0]} ${-this.high[1]} ${width} ${height}`);
    const world = svg("g", { transform: "scale(1,-1)" });
    const shapes = areas.map((area) => svg("polygon", { class: area?.role, points: outline(area?.outline ?? []) }));
    world.append(...shapes);
    this.movers = shapes.filter((_, place) => !areas[place] || areas[place].role === "moving");
    this.seen = shapes.filter((_, place) => areas[place]?.role === "seen");
    this.path = svg("polyline", { class: "path" });
    const smallest = 0.012 * Math.max(width, height);
    const radius = Math.max(this.world?.robot_radius_m || 0.15, smallest);
    const hull = this.world?.robot_outline;
    const body = hull && radius > smallest ? svg("polygon", { points: outline(hull) }) : svg("circle", { r: radius });
    this.robot = svg("g", { class: "robot" }, body, svg("path", { d: `M0,0H${radius * 1.7}` }));
    world.append(this.path, this.robot);
    this.root.append(world);
    this.moveRobot();
  }

  moveRobot() {
    if (!this.path) return;
    const pose = this.track?.pose;
    for (const node of [this.robot, ...this.seen]) node.setAttribute("visibility", pose ? "visible" : "hidden");
    if (!pose) return;
    this.path.setAttribute("points", outline([...this.points, pose]));
    for (const node of [this.robot, ...this.seen]) node.setAttribute("transform", placed(pose));
    this.movers.forEach((shape, index) => {
      const at = this.track.moving[index];
      if (at) shape.setAttribute("transform", placed(at));
    });
  }

  isOutside() {
    const pose = this.track?.pose;
    return Boolean(pose && this.low) && [0, 1].some((axis) => pose[axis] < this.low[axis] || pose[axis] > this.high[axis]);
  }

  point(event) {
    const matrix = this.root.getScreenCTM();
    if (!matrix) return;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    this.at = [at.x, -at.y];
    this.say();
  }

  say() {
    const parts = [];
    if (this.track) {
      const [x, y, yaw] = this.track.pose;
      parts.push(`robot ${x.toFixed(2)}, ${y.toFixed(2)} m, ${((yaw * 180) / Math.PI).toFixed(0)}°`);
    }
    if (this.at) parts.push(`cursor ${this.at[0].toFixed(2)}, ${this.at[1].toFixed(2)} m`);
    setText(this.readout, parts.join("  ·  ") || "\u00a0");
  }
}

const outline = (points) => points.map(([x, y]) => `${x},${y}`).join(" ");
const placed = ([x, y, yaw]) => `translate(${x},${y}) rotate(${(yaw * 180) / Math.PI})`;
