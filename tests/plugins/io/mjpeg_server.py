"""Serve a picture as motion JPEG for ever: python mjpeg_server.py PORT PICTURE.jpg; port 0 is any, which it prints."""

import sys
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

PICTURE = Path(sys.argv[2]).read_bytes()


class Stream(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        self.end_headers()
        head = f"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: {len(PICTURE)}\r\n\r\n".encode()
        try:
            while True:
                self.wfile.write(head + PICTURE + b"\r\n")
                time.sleep(0.03)
        except OSError:  # it has gone
            return

    def log_message(self, *_: object) -> None:
        """Stay silent."""


server = ThreadingHTTPServer(("127.0.0.1", int(sys.argv[1])), Stream)
print(server.server_port, flush=True)
server.serve_forever()
