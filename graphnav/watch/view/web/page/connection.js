// The WebSocket to the page's server: one update in flight, with automatic reconnection.

const AGAIN_MS = 1000;

export class Connection {
  // `on` has `hello`, `update` (a message and its picture, drawn when its promise resolves) and `state` ("open", "lost").
  constructor(on) {
    this.on = on;
    this.view = null;
    this.connect();
  }

  connect() {
    const socket = new WebSocket(`ws://${location.host}/updates`);
    socket.binaryType = "blob";
    this.socket = socket;
    let waiting = null;
    socket.addEventListener("open", () => {
      this.on.state("open");
      if (this.view) this.send(this.view);
    });
    socket.addEventListener("message", ({ data }) => {
      if (typeof data !== "string") {
        this.draw(socket, waiting, data);
        return;
      }
      const message = JSON.parse(data);
      if (message.kind === "hello") this.on.hello(message);
      else if (message.has_picture) waiting = message;
      else this.draw(socket, message, null);
    });
    socket.addEventListener("close", () => {
      this.on.state("lost");
      setTimeout(() => this.connect(), AGAIN_MS);
    });
  }

  // The server waits until this has been drawn: a hidden page gets no updates.
  async draw(socket, message, picture) {
    try {
      await this.on.update(message, picture);
    } finally {
      requestAnimationFrame(() => {
        if (socket === this.socket) this.send({ kind: "shown", number: message.number });
      });
    }
  }

  show(view) {
    this.view = { kind: "view", ...view };
    this.send(this.view);
  }

  order(action, value = 0) {
    this.send({ kind: "log", action, value });
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}
