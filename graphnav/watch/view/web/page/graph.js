// The graph as drawn by `graphnav draw`, with live labels on edges and boxes.

import { printable, setClass, setText, svg } from "./dom.js";
import * as format from "./format.js";
import { shownProcess } from "./processes.js";

const HEAD = 36;
// Narrow windows scroll: the minimum legible scale is --graph-scale of the style sheet.
const MAX_SCALE = 1.15;

export class Graph {
  // `choose` is called with the LCM channel of the selected edge.
  constructor(holder, choose) {
    this.holder = holder;
    this.choose = choose;
    this.ports = [];
    this.boxes = new Map();
    this.readers = [];
  }

  draw(layout) {
    this.ports = [];
    this.boxes = new Map();
    this.readers = [];
    const root = svg("svg", {
      viewBox: `0 0 ${layout.width} ${layout.height}`, width: layout.width, height: layout.height, class: "graph",
      role: "group", "aria-label": "graph",
    });
    const byRef = Map.groupBy
      ? Map.groupBy(layout.wires, (wire) => wire.ref)
      : layout.wires.reduce((map, wire) => map.set(wire.ref, [...(map.get(wire.ref) ?? []), wire]), new Map());
    const labels = [];
    for (const box of layout.boxes) {
      for (const port of box.outputs) {
        const group = this.port(box, port, byRef.get(port.ref) ?? [], layout.names[port.ref] ?? [port.ref]);
        root.append(group.wires);
        labels.push(group.label);
      }
    }
    root.append(...layout.boxes.map((box) => this.box(box)));
    root.append(...labels, ...layout.wires.map((wire) => this.reader(wire)));
    root.style.minWidth = `calc(var(--graph-scale) * ${layout.width}px)`;
    root.style.maxWidth = `${MAX_SCALE * layout.width}px`;
    this.holder.replaceChildren(root);
  }

  // An output port with all of its wires: one channel, one click target.
  port(box, port, wires, names) {
    const x = box.x + box.width;
    const wireGroup = svg("g", { class: "wires" });
    for (const wire of wires) {
      const [endX, endY] = wire.end;
      wireGroup.append(
        svg("path", { class: "hit", d: wire.path }),
        svg("path", { class: wire.sampled ? "wire sampled" : "wire", stroke: wire.colour, d: wire.path }),
        svg("path", { class: "head", fill: wire.colour, d: `M${endX},${endY}l-7,-4v8z` }),
      );
    }
    if (!wires.length) wireGroup.append(svg("path", { class: "wire stub", stroke: box.colour, d: `M${x},${port.y}h12` }));
    const rate = svg("text", { class: "rate", x: x + 6, y: port.y - 4 });
    const lost = svg("text", { class: "lost", x: x + 6, y: port.y + 12 });
    const title = svg("title");
    const label = svg(
      "g", { class: "edge", tabindex: 0, role: "button" },
      title, svg("rect", { class: "hit", x, y: port.y - 16, width: 84, height: 32 }),
      svg("circle", { cx: x, cy: port.y, r: 3, fill: box.colour }), rate, lost,
    );
    const found = { names, label, wireGroup, rate, lost, title, ref: port.ref, name: names[0] };
    const chosen = () => this.choose(found.name);
    label.addEventListener("click", chosen);
    wireGroup.addEventListener("click", chosen);
    label.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      chosen();
    });
    this.ports.push(found);
    return { wires: wireGroup, label };
  }

  box(box) {
    const { x, y, width, height } = box;
    const band = `M${x},${y + HEAD}v${6 - HEAD}q0,-6 6,-6h${width - 12}q6,0 6,6v${HEAD - 6}z`;
    const floor = y + height - 8;
    const group = svg("g", { class: "stage" });
    const title = svg("title");
    group.append(
      title,
      svg("rect", { class: "body", x, y, width, height, rx: 6 }),
      svg("path", { fill: box.colour, d: band }),
      svg("text", { class: "name", x: x + 9, y: y + 15, text: box.name }),
      svg("text", { class: "use", x: x + 9, y: y + 30, text: box.use }),
    );
    for (const port of box.inputs) {
      group.append(svg("text", { x: x + 9, y: port.y + 4, text: port.name }));
      if (port.open) group.append(svg("circle", { class: "open", cx: x, cy: port.y, r: 3.5 }));
    }
    for (const port of box.outputs) {
      const name = svg("text", { x: x + width - 9, y: port.y + 4, "text-anchor": "end", text: port.name });
      if (port.alias) name.append(svg("tspan", { class: "renamed", dx: 5, text: port.alias }));
      group.append(name);
    }
    if (box.kind === "source" || box.kind === "stage") {
      const usual = svg("text", { class: "time", x: x + 9, y: floor });
      const worst = svg("text", { class: "time worst", x: x + width - 9, y: floor, "text-anchor": "end" });
      group.append(svg("path", { class: "rule", d: `M${x},${floor - 16}h${width}` }), usual, worst);
      this.boxes.set(box.name, { usual, worst, title, group });
    }
    return group;
  }

  // The process that a wire comes from, if it is another one, and its messages overtaken at the reader: below the port's name.
  reader(wire) {
    const text = svg("text", { class: "lost", x: wire.end[0] + 9, y: wire.end[1] + 14 });
    this.readers.push({ name: wire.reader, text });
    return text;
  }

  update(state, channels, chosen) {
    const status = state.run?.status;
    const inputs = new Map((status?.inputs ?? []).map((input) => [input.name, input]));
    const outputs = new Map((status?.outputs ?? []).map((output) => [output.name, output]));
    for (const port of this.ports) this.label(port, channels, chosen, inputs.get(port.ref), outputs.get(port.ref));
    const stages = new Map((status?.stages ?? []).map((stage) => [stage.name, stage]));
    const homes = new Map();
    for (const process of status?.processes ?? []) for (const name of process.stages) homes.set(name, process);
    for (const [name, box] of this.boxes) {
      const stage = stages.get(name);
      setText(box.usual, stage ? format.milliseconds(stage.p50_ms) : format.NONE);
      setText(box.worst, stage ? this.worst(stage) : "");
      setClass(box.worst, "bad", stage?.missed);
      setClass(box.group, "silent", Boolean(state.run?.silent));
      setText(box.title, stage ? this.about(stage, homes.get(name)) : name);
    }
    const edges = new Map((status?.edges ?? []).map((edge) => [edge.name, edge]));
    for (const reader of this.readers) {
      const edge = edges.get(reader.name);
      const [from, to] = edge?.processes ?? [];
      const says = from === to ? [] : [`from ${shownProcess(from)}`];
      if (edge?.overtaken) says.push(`${format.count(edge.overtaken)} overtaken`);
      setText(reader.text, says.join(" · "));
      setClass(reader.text, "bad", edge?.overtaken);
    }
  }

  // The run's own status of an input or output takes precedence over local statistics.
  label(port, channels, chosen, input, output) {
    port.name = port.names.find((name) => channels.get(name)?.count) ?? port.names[0];
    const channel = channels.get(port.name);
    const rateHz = channel?.rate_hz ?? input?.rate_hz;
    const delayMs = output?.sent ? output.latency_p50_ms : channel?.pipeline_ms;
    const rejected = Object.values(input?.rejected ?? {}).reduce((sum, n) => sum + n, 0);
    const lost = input?.lost ?? channel?.lost;
    const drops = [channel?.count ? `${format.count(lost)} lost` : "not received"];
    if (rejected) drops.push(`${format.count(rejected)} rejected`);
    if (input?.fault) drops.push(input.fault);
    const times = delayMs == null ? [] : [format.milliseconds(delayMs)];
    setText(port.rate, channel?.once ? "once" : format.rate(rateHz));
    // Only the worst fits between two boxes; the tooltip has all.
    setText(port.lost, (drops.length > 1 ? drops.slice(-1) : [...times, ...drops]).join(" · "));
    setClass(port.lost, "bad", lost || rejected || input?.fault);
    setClass(port.label, "silent", !channel?.count || (channel.silent && !channel.once));
    for (const node of [port.label, port.wireGroup]) setClass(node, "chosen", port.name === chosen);
    const label = `${printable(port.ref)}: ${port.rate.textContent}, ${[...times, ...drops].join(" · ")}`;
    setText(port.title, label);
    if (port.label.getAttribute("aria-label") !== label) port.label.setAttribute("aria-label", label);
  }

  worst(stage) {
    return stage.missed ? `${format.count(stage.missed)} missed` : `p99 ${format.milliseconds(stage.p99_ms).replace(" ms", "")}`;
  }

  about(stage, process) {
    const deadline = stage.deadline_ms ? `, deadline ${format.milliseconds(stage.deadline_ms)}` : "";
    return `${stage.name} (${stage.use}): ${stage.steps} steps, ${format.rate(stage.rate_hz)}, ` +
      `p50 ${format.milliseconds(stage.p50_ms)}, p99 ${format.milliseconds(stage.p99_ms)}${deadline}, ` +
      `${stage.missed} missed, ${stage.overtaken} overtaken` +
      (process ? `, in process ${shownProcess(process.name)}, ${process.state}` : "") +
      (stage.restarts ? `, started again ${stage.restarts} times` : "");
  }
}
