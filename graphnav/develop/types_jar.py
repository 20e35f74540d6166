"""Build the jar by which LCM's Java tools decode types, once, in the user's cache."""

from __future__ import annotations

import hashlib
import json
import tempfile
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Final

from graphnav import UserError
from graphnav.core.machine import no_user_folder, user_folder
from graphnav.core.typeinfo import definition_files
from graphnav.develop.java import write_java
from graphnav.develop.jdk import require_jdk

_CACHE: Final = "XDG_CACHE_HOME"


def types_jar(lcm_classes: Iterable[type]) -> Path:
    """Return the jar of types and all nested types; build it unless the cache has one of the same content.

    Raises
    ------
    UserError
        No JDK is installed, or the cache cannot be written or has no folder.
    GraphnavError
        A tool fails, or is missing in the package ``lcm``.
    """
    classes = list(lcm_classes)
    jdk = require_jdk()
    content = [version("lcm"), str(jdk.javac and jdk.javac.resolve()), definition_files(classes)]
    key = hashlib.sha256(json.dumps(content).encode()).hexdigest()[:24]
    cache = user_folder(_CACHE)
    if cache is None:
        raise UserError.of("no folder for the jar of types", no_user_folder(_CACHE))
    folder = cache / "java"
    jar = folder / f"types-{key}.jar"
    try:
        if jar.is_file():
            return jar
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            write_java(classes, Path(scratch)).jar.replace(jar)
    except OSError as error:
        what = f"cannot write {folder}: {error.strerror}"
        raise UserError.of(what, f"set {_CACHE} to a writable folder") from error
    return jar
