// The table of all channels, including those that are not in the graph.

import { element, setClass, setText } from "./dom.js";
import * as format from "./format.js";


export class Channels {
  constructor(body, choose) {
    this.body = body;
    this.choose = choose;
    this.rows = new Map();
  }

  update(channels, chosen) {
    const names = [...channels.keys()].sort();
    if (names.join("\n") !== [...this.rows.keys()].join("\n")) this.arrange(names);
    for (const [name, row] of this.rows) this.fill(row, channels.get(name), name === chosen);
  }

  // Rows are kept, so that the focus is not lost when a channel appears.
  arrange(names) {
    const rows = new Map(names.map((name) => [name, this.rows.get(name) ?? this.row(name)]));
    for (const [name, row] of this.rows) if (!rows.has(name)) row.line.remove();
    let before = null;
    for (const row of rows.values()) {
      const place = before ? before.nextSibling : this.body.firstChild;
      if (place !== row.line) this.body.insertBefore(row.line, place);
      before = row.line;
    }
    this.rows = rows;
  }

  row(name) {
    const button = element("button", { type: "button", title: name, text: name });
    const type = element("span", { class: "type" });
    const cells = ["rate", "delay", "lost", "bad-count", "size", "age"].map((kind) => element("td", { class: kind }));
    const line = element("tr", {}, element("th", { scope: "row" }, button, type), ...cells);
    line.addEventListener("click", () => this.choose(name));
    return { line, button, type, cells };
  }

  fill({ line, button, type, cells }, channel, isChosen) {
    setText(type, channel.type || "unknown type");
    const isSilent = !channel.count || (channel.silent && !channel.once);
    const values = [
      channel.once ? "once" : format.rate(channel.rate_hz), format.milliseconds(channel.pipeline_ms), format.count(channel.lost),
      format.count(channel.undecodable), channel.count ? format.size(channel.bytes) : format.NONE,
      format.seconds(channel.age_s),
    ];
    cells.forEach((cell, index) => setText(cell, values[index]));
    setClass(cells[2], "bad", channel.lost);
    setClass(cells[3], "bad", channel.undecodable);
    setClass(line, "silent", isSilent);
    setClass(line, "chosen", isChosen);
    if (button.getAttribute("aria-pressed") !== String(isChosen)) button.setAttribute("aria-pressed", isChosen);
  }
}
