// The processes of a run, and which way its edges take; hidden where all stages live in one.

import { byId, element, fill, setClass, setText } from "./dom.js";
import * as format from "./format.js";

// Any program may send a status of any length.
const MAX_ROWS = 200;
const OWN = "(run)";

export const shownProcess = (name) => name || OWN;

export class Processes {
  constructor() {
    this.panel = byId("processes-panel");
    this.processes = byId("processes").tBodies[0];
    this.edges = byId("edges").tBodies[0];
    this.more = byId("processes-more");
  }

  update(state) {
    const status = state.run?.status;
    const processes = status?.processes ?? [];
    const edges = processes.length ? status.edges : [];
    this.panel.hidden = !processes.length;
    setClass(this.panel, "silent", state.run?.silent);
    setClass(this.panel, "no-hosts", !processes.some((one) => one.host));
    table(this.processes, processes, process);
    table(this.edges, edges, (one) => edge(one, status.live));
    const left = Math.max(0, processes.length - MAX_ROWS) + Math.max(0, edges.length - MAX_ROWS);
    this.more.hidden = !left;
    setText(this.more, `and ${left} more`);
  }
}

function table(body, items, cells) {
  const rows = items.slice(0, MAX_ROWS).map(cells);
  fill(body, rows, (row) => element("tr", {}, ...row.map(() => element("td"))), (line, row) => {
    row.forEach(([text, isBad], place) => {
      setText(line.children[place], text);
      setClass(line.children[place], "bad", isBad);
    });
  });
}

function process(one) {
  return [
    [shownProcess(one.name)],
    [one.stages.join(", ")],
    [one.pid || format.NONE],
    [one.state, one.state !== "ready"],
    [format.count(one.restarts), one.restarts > 0],
    [`${(100 * (one.cpu_ratio ?? 0)).toFixed(0)} %`],
    [`${(one.memory_mb ?? 0).toFixed(0)} MB`],
    [one.host_shown, one.clock_steps > 0],
  ];
}

function edge(one, isLive) {
  const [writer, reader] = one.processes.map(shownProcess);
  return [
    [one.name],
    [one.channel],
    [writer === reader ? `within ${reader}` : `${writer} → ${reader}`],
    [isLive ? format.count(one.overtaken) : format.NONE, one.overtaken > 0],
  ];
}
