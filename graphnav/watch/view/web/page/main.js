// The page: passes the parts of the server's updates to their components.

import { Channels } from "./channels.js";
import { Connection } from "./connection.js";
import { Details } from "./details.js";
import { byId, setText } from "./dom.js";
import { Floor } from "./floor.js";
import { Graph } from "./graph.js";
import { Heading } from "./heading.js";
import { Processes } from "./processes.js";
import { Timeline } from "./timeline.js";

const IMAGE = "graphnav_lcm.image_t";

const shown = { channel: null, run: null, cursor: null, map: true };
let state = null;
let channels = new Map();

const graph = new Graph(byId("graph-scroll"), open);
const processes = new Processes();
const table = new Channels(byId("channels").tBodies[0], open);
const details = new Details((cursor) => {
  shown.cursor = cursor;
  ask();
});
const floor = new Floor({ box: byId("map-box"), readout: byId("map-readout"), empty: byId("map-empty") });
const heading = new Heading((run) => {
  shown.run = run;
  ask();
});
const timeline = new Timeline((action, value) => connection.order(action, value));
const connection = new Connection({
  hello(hello) {
    heading.hello(hello);
    floor.reset();
    if (!hello.log) return;
    timeline.show(hello.length_s);
    setText(byId("graph-empty"), "The log is being read.");
  },
  state: (name) => heading.connected(name),
  update,
});
ask();

function ask() {
  connection.show(shown);
}

function open(channel) {
  shown.channel = channel;
  shown.cursor = null;
  details.open(channel);
  ask();
  refresh();
}

async function update(message, picture) {
  if (message.graph) drawGraph(message.graph);
  if (message.state) {
    const isOtherRun = state !== null && state.run_id !== message.state.run_id;
    state = message.state;
    channels = new Map(state.channels.map((channel) => [channel.name, channel]));
    heading.update(state);
    processes.update(state);
    if (state.log) {
      timeline.update(state.log);
      if (!state.run_id && channels.size > 0) {
        setText(byId("graph-empty"), "The log does not hold the graph that produced it.");
      }
    }
    if (isOtherRun) {
      floor.reset();
      if (!channels.has(shown.channel)) shown.channel = null;
    }
    if (shown.channel === null) openFirst();
    byId("channels-empty").hidden = channels.size > 0;
    refresh();
  }
  if (message.world !== undefined || message.track) floor.update(message.world, message.track);
  if (message.details) await details.update(message.details, picture);
}

function refresh() {
  if (!state) return;
  graph.update(state, channels, shown.channel);
  table.update(channels, shown.channel);
  details.say(channels.get(shown.channel));
}

function drawGraph(layout) {
  const empty = byId("graph-empty");
  empty.hidden = !layout.failure;
  byId("graph-scroll").hidden = Boolean(layout.failure);
  if (layout.failure) {
    setText(empty, `The graph cannot be drawn: ${layout.failure}`);
    return;
  }
  setText(byId("graph-title"), layout.about || "Graph");
  graph.draw(layout);
  refresh();
}

// Initially show the picture of a camera, if there is one.
function openFirst() {
  const received = state.channels.filter((channel) => channel.count);
  const first = received.find((channel) => channel.type === IMAGE);
  if (first) open(first.name);
}
