"""A serial line that never makes its caller wait: raw bytes by the terminal interface of Linux.

Eight bits, no parity, one stop bit, no flow control. The kernel's interface is all that is needed, so no library is.
"""

from __future__ import annotations

import errno
import fcntl
import os
import struct
import termios
from contextlib import suppress

RATES = {
    int(name[1:]): getattr(termios, name) for name in dir(termios) if name.startswith("B") and name[1:].isdecimal()
}
"""The kernel's constants of the bits per second that it knows."""
_CFLAG, _ISPEED, _OSPEED, _CC = 2, 4, 5, 6
"""Places in what `termios.tcgetattr` returns."""
_READ_BYTES = 4096


class SerialLine:
    """An open serial line; raises OSError if it cannot be opened, or is not a serial line.

    It is locked: no other program opens it too, except one of root. A modem's signals are ignored.
    """

    def __init__(self, path: str, baud: int) -> None:
        self._fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            attributes = termios.tcgetattr(self._fd)
            attributes[:_CFLAG] = [0, 0]
            attributes[_CFLAG:_CC] = [termios.CS8 | termios.CREAD | termios.CLOCAL, 0, RATES[baud], RATES[baud]]
            attributes[_CC][termios.VMIN], attributes[_CC][termios.VTIME] = 0, 0
            termios.tcsetattr(self._fd, termios.TCSANOW, attributes)
            termios.tcflush(self._fd, termios.TCIOFLUSH)
            with suppress(OSError):
                fcntl.ioctl(self._fd, termios.TIOCEXCL)
        except termios.error as error:
            os.close(self._fd)
            raise OSError(errno.ENOTTY, "it is not a serial line") from error

    def fileno(self) -> int:
        """Return the descriptor, which is readable when bytes have come or the line is gone."""
        return self._fd

    def pending_bytes(self) -> int:
        """Return how many bytes have not left yet; raises OSError if the line is gone."""
        answer = fcntl.ioctl(self._fd, termios.TIOCOUTQ, struct.pack("i", 0))
        return int(struct.unpack("i", answer)[0])

    def write(self, data: bytes) -> int:
        """Write what fits and return how much that was; raises OSError if the line is gone."""
        try:
            return os.write(self._fd, data)
        except BlockingIOError:
            return 0

    def read(self) -> bytes:
        """Return the bytes that have come, empty for none; raises OSError if the line is gone."""
        try:
            return os.read(self._fd, _READ_BYTES)
        except BlockingIOError:
            return b""

    def close(self) -> None:
        """Close it; what has not left is dropped, so that the end of the program waits for nothing."""
        with suppress(termios.error):
            termios.tcflush(self._fd, termios.TCOFLUSH)
        os.close(self._fd)
