"""The key of connections between hosts: 32 random bytes, in a file that only its user may read."""

from __future__ import annotations

import os
import secrets
import stat
from contextlib import suppress
from pathlib import Path

from graphnav import UserError
from graphnav.core.machine import no_user_folder, path_aside, user_folder

_KEY_BYTES = 32
_MAX_KEY_FILE_BYTES = 256
_KEY_FILE = "hosts.key"


def key_file(given: Path | None) -> Path:
    """Return the file of the key: the given one, or that of this user.

    Raises
    ------
    UserError
        The user has no folder for it.
    """
    if given is not None:
        return given
    folder = user_folder("XDG_STATE_HOME")
    if folder is None:
        raise UserError.of(no_user_folder("XDG_STATE_HOME"), "or name a file for the key: --key FILE")
    return folder / _KEY_FILE


def read_key(path: Path) -> bytes:
    """Return the key in a file.

    Raises
    ------
    UserError
        It is missing, or other users may read it.
    """
    try:
        found = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        with os.fdopen(found, "rb") as file:
            mode = os.fstat(found).st_mode
            text = file.read(_MAX_KEY_FILE_BYTES) if stat.S_ISREG(mode) else b""
    except FileNotFoundError as error:
        hint = (
            f"'graphnav tunnel --serve' or 'run --host' on the other host makes one: copy it, with mode 0600, to {path}"
        )
        raise UserError.of(f"the key {path} does not exist", hint) from error
    except OSError as error:
        raise UserError.of(f"cannot read the key in {path}: {error.strerror}", "name another file: --key") from error
    if mode & 0o077:
        raise UserError.of(f"other users may read or change the key in {path}", f"run chmod 600 {path}")
    key = key_of(text.decode("ascii", "replace").strip())
    if key is None:
        hint = f"it has {2 * _KEY_BYTES} hexadecimal digits: copy it again"
        raise UserError.of(f"{path} does not contain a key", hint)
    return key


def new_key() -> bytes:
    """Return a new key."""
    return secrets.token_bytes(_KEY_BYTES)


def key_of(digits: str) -> bytes | None:
    """Return the key of its hexadecimal digits, None if they are not of one."""
    with suppress(ValueError):
        if len(key := bytes.fromhex(digits)) == _KEY_BYTES:
            return key
    return None


def made_key(path: Path) -> tuple[bytes, bool]:
    """Return the key in a file, and whether it was made now because there was none.

    Raises
    ------
    UserError
        It cannot be made or read.
    """
    if path.exists():
        return read_key(path), False
    aside = path_aside(path)
    is_made = True
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        with os.fdopen(os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600), "wb") as file:
            file.write(new_key().hex().encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
        os.link(aside, path)  # unlike a renaming it replaces no key that another process has made meanwhile
    except FileExistsError:
        is_made = False
    except OSError as error:
        raise UserError.of(f"cannot write the key to {path}: {error.strerror}", "name another file: --key") from error
    finally:
        with suppress(OSError):
            aside.unlink()
    return read_key(path), is_made
