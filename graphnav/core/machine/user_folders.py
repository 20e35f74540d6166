"""The user's folders of graphnav, as the XDG Base Directory specification places them: its state and its cache."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Literal

if sys.platform != "win32":
    import pwd

_BELOW_HOME = {"XDG_STATE_HOME": (".local", "state"), "XDG_CACHE_HOME": (".cache",)}


def user_folder(variable: Literal["XDG_STATE_HOME", "XDG_CACHE_HOME"]) -> Path | None:
    """Return the folder of graphnav below that of an XDG variable, or where the variable says it is by default.

    A variable that is unset, empty or relative is ignored, as the specification demands. None without a home folder.
    It may not exist.
    """
    root = os.environ.get(variable, "")
    if os.path.isabs(root):
        return Path(root, "graphnav")
    home = _home()
    return None if home is None else Path(home, *_BELOW_HOME[variable], "graphnav")


def no_user_folder(variable: str) -> str:
    """Return why `user_folder` is None, and what to do about it."""
    return f"this user has no home folder: set {variable} to an absolute path"


def _home() -> str | None:
    """Return the home folder: ``HOME``, else that of the password database, which an empty ``HOME`` must not hide.

    On Windows it is that of the user's profile.

    `Path.home` would return the root folder, or the working folder.
    """
    if sys.platform == "win32":
        profile = os.environ.get("USERPROFILE", "")
        return profile if os.path.isabs(profile) else None
    home = os.environ.get("HOME", "")
    if not os.path.isabs(home):
        try:
            home = pwd.getpwuid(os.getuid()).pw_dir
        except KeyError:  # a user of a container without an entry
            return None
    return home if os.path.isabs(home) else None
