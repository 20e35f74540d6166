// The heading of the page: the run, its health, the guard's decision, problems.

import { byId, element, fill, setClass, setText } from "./dom.js";
import * as format from "./format.js";

const LINK = { open: "connected", lost: "no connection: graphnav view has ended or cannot be reached" };

export class Heading {
  constructor(chooseRun) {
    this.link = byId("link");
    this.digits = byId("run-digits");
    this.notices = byId("notices");
    this.choice = byId("run-choice");
    this.runs = byId("run");
    this.runs.addEventListener("change", () => chooseRun(this.runs.value));
  }

  hello({ name }) {
    setText(byId("feed"), name);
  }

  connected(state) {
    setText(this.link, LINK[state]);
    this.link.dataset.state = state;
    document.body.classList.toggle("lost", state === "lost");
  }

  update(state) {
    this.chooseFrom(state.runs.filter(Boolean), state.run_id);
    fill(
      this.digits, digits(state),
      () => element("div", {}, element("dt"), element("dd")),
      (item, [name, value, isBad]) => {
        setText(item.children[0], name);
        setText(item.children[1], value);
        setClass(item, "bad", isBad);
      },
    );
    fill(this.notices, notices(state), () => element("li"), (item, [text, isBad]) => {
      setText(item, text);
      setClass(item, "bad", isBad);
    });
  }

  chooseFrom(runs, shown) {
    this.choice.hidden = runs.length < 2;
    if (document.activeElement === this.runs) return;
    fill(this.runs, runs, () => element("option"), (option, run) => {
      setText(option, run);
      option.value = run;
    });
    this.runs.value = shown ?? "";
  }
}

function digits({ run, run_id: id }) {
  const status = run?.status;
  if (!status) return id ? [["run", id, false]] : [];
  const dropped = status.tap_dropped + status.log_dropped;
  return [
    ...(id ? [["run", id, false]] : []),
    ["graph", status.graph, false],
    [status.live ? "live" : "simulated", format.seconds(status.run_s), false],
    ["wall time", format.seconds(status.wall_s), false],
    ["behind", format.seconds(status.behind_s), status.behind_s > 0.5],
    ["memory", `${(status.memory_mb ?? 0).toFixed(0)} MB`, false],
    ["dropped", format.count(dropped), dropped > 0],
  ];
}

function notices(state) {
  const found = [];
  if (state.failure) found.push([state.failure, true]);
  if (state.losses) found.push([state.losses, true]);
  if (state.log?.damage) found.push([`the log is damaged: ${state.log.damage}`, true]);
  if (state.run?.silent) found.push([`no status of the run for ${format.seconds(state.run.silent_s)}`, true]);
  if (state.run?.status?.log_fault) found.push([`not recording: ${state.run.status.log_fault}`, true]);
  if (state.untracked) found.push([`${format.count(state.untracked)} messages on further channels are not shown`, true]);
  if (state.dropped_packets) found.push([`${format.count(state.dropped_packets)} packets dropped by the kernel`, true]);
  if (state.refused) found.push([`${format.count(state.refused)} announcements cannot be read`, true]);
  for (const guard of state.guards) found.push(guardNotice(guard));
  return found;
}

function guardNotice(guard) {
  if (guard.silent) return [`${guard.channel}: no state for ${format.seconds(guard.silent_s)}`, true];
  const may = !guard.may_move ? "may not move" : guard.may_advance ? "may move" : "may turn, not advance";
  const causes = guard.causes.map(({ cause, port }) => `${cause} ${port}`);
  const fault = guard.motor_fault ? `but ${guard.motor_fault}` : "";
  const retries = guard.retrying ? "retries slowly" : "";
  const more = [fault, retries, guard.overridden ? "override active" : "", guard.stopped ? "stopped until armed again" : "", ...causes];
  return [`${guard.channel}: ${[may, ...more.filter(Boolean)].join(", ")}`, !guard.may_advance || guard.retrying || fault !== ""];
}
