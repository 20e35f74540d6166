"""MuJoCo and what it draws with: an extra and a system library, found before a run needs them."""

from __future__ import annotations

import ctypes
import importlib
import os
from typing import Any

from graphnav import UserError, import_extra

LIBRARIES = {"osmesa": ("libOSMesa.so.8", "libOSMesa.so"), "egl": ("libEGL.so.1",)}
"""Libraries that draw without a window, in the order of preference: OSMesa always computes on the CPU."""
CHOSEN_BY = "MUJOCO_GL"


def load() -> Any:
    """Return the module of MuJoCo, which draws with what `choose_gl` finds.

    Raises
    ------
    UserError
        MuJoCo or a library to draw with is not installed.
    """
    choose_gl()
    return import_extra("mujoco", "mujoco", "world.mujoco", "MuJoCo")


def choose_gl() -> None:
    """Choose what MuJoCo draws with, unless the environment does; llvmpipe then computes in one thread.

    MuJoCo reads the choice when it is imported.

    Raises
    ------
    UserError
        Neither OSMesa nor EGL is installed.
    """
    os.environ.setdefault("LP_NUM_THREADS", "0")
    chosen = os.environ.get(CHOSEN_BY, "").lower().strip()
    if chosen and chosen not in LIBRARIES:  # a window system, which MuJoCo asks itself
        return
    for name in (chosen,) if chosen else LIBRARIES:
        if any(_loads(library) for library in LIBRARIES[name]):
            os.environ[CHOSEN_BY] = name
            return
    needed = f"what {CHOSEN_BY} names, {chosen}," if chosen else "OSMesa or EGL"
    raise UserError.of(f"world.mujoco needs {needed} to draw", "apt install libosmesa6, or libegl1 libegl-mesa0")


def new_context(cols: int, rows: int) -> Any:
    """Return a context of OpenGL that draws into a buffer.

    Raises
    ------
    UserError
        The library has no driver that draws.
    """
    mujoco = load()
    chosen = os.environ[CHOSEN_BY].lower().strip()
    try:
        # mujoco.GLContext is of what was chosen when the module was imported, by whomever
        draws_by = importlib.import_module(f"mujoco.{chosen}") if chosen in LIBRARIES else mujoco
        return draws_by.GLContext(cols, rows)
    except (RuntimeError, ImportError, AttributeError) as error:
        what = f"world.mujoco cannot draw by {os.environ.get(CHOSEN_BY)}: {error}"
        raise UserError.of(what, f"apt install libosmesa6, and set {CHOSEN_BY}=osmesa") from error


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
