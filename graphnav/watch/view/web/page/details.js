// The open channel: its newest message as picture, plot and fields, or why there is none.

import { byId, element, fill, setText } from "./dom.js";
import * as format from "./format.js";
import { Picture } from "./picture.js";
import { Plot } from "./plot.js";

const WHY = {
  not_received: "No message has been received on this channel yet.",
  "too large": "The messages are too large to be shown here.",
  "unknown type": "The message type is not installed, so messages cannot be decoded.",
  undecodable: "The newest message cannot be decoded.",
};

export class Details {
  constructor(point) {
    this.title = byId("details-title");
    this.type = byId("details-type");
    this.empty = byId("details-empty");
    this.plotBox = byId("plot-box");
    this.fields = byId("fields").tBodies[0];
    const [box, canvas, cross, readout] = ["picture-box", "picture", "cross", "readout"].map(byId);
    this.picture = new Picture({ box, canvas, cross, readout }, point);
    this.plot = new Plot(byId("plot"), byId("legend"));
    this.channel = null;
  }

  open(channel) {
    this.channel = channel;
    setText(this.title, channel);
    setText(this.type, "\u00a0");
    this.picture.cursor = null;
  }

  async update(details, blob) {
    if (details.channel !== this.channel) return;
    const why = WHY[details.missing] ?? (details.no_picture ? `No picture: ${details.no_picture}` : "");
    setText(this.empty, why);
    this.empty.hidden = !why;
    if (details.reset) this.plot.reset();
    if (blob) await this.picture.show(blob);
    else if (!details.fields || details.reset || details.no_picture) this.picture.hide();
    if (details.fields) {
      this.plot.add(details.series, details.points, details.reset);
      this.picture.say(details.has_cells, details.under_cursor);
    }
    this.plotBox.hidden = this.plot.isEmpty;
    this.plot.draw();
    fill(
      this.fields, Object.entries(details.fields ?? {}),
      () => element("tr", {}, element("th", { scope: "row" }), element("td")),
      (line, [name, value]) => {
        setText(line.children[0], name);
        setText(line.children[1], format.field(value));
      },
    );
  }

  say(channel) {
    if (!channel) return;
    const parts = [channel.type || "unknown type", `${format.count(channel.count)} messages`, channel.once ? "once" : format.rate(channel.rate_hz)];
    setText(this.type, parts.join("  ·  "));
  }
}
