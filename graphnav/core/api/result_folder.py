"""The folder of a run or a study: named by the caller, or temporary."""

from __future__ import annotations

import os
import shutil
import tempfile
import weakref
from pathlib import Path

from graphnav.core.api.arguments import Argument, PathLike
from graphnav.core.api.parameters import Shared
from graphnav.core.errors import UserError
from graphnav.core.parameters import Parameter


class KeptFolder:
    """A folder; a temporary one is removed with the last object that refers to this."""

    def __init__(self, path: Path, *, is_temporary: bool) -> None:
        self.path = path
        self.is_temporary = is_temporary
        if is_temporary:
            weakref.finalize(self, shutil.rmtree, path, ignore_errors=True)

    @staticmethod
    def temporary() -> KeptFolder:
        """Return a new folder in the system's temporary folder.

        Raises
        ------
        UserError
            It cannot be created.
        """
        try:
            return KeptFolder(Path(tempfile.mkdtemp(prefix="graphnav-")), is_temporary=True)
        except OSError as error:
            raise UserError.of(
                f"cannot create a temporary folder: {error.strerror or error}", 'write folder="runs/1"'
            ) from error

    @staticmethod
    def named(given: PathLike, declared: Parameter) -> KeptFolder:
        """Return a folder that may hold what an earlier call left; ``declared``: the parameter.

        Raises
        ------
        UserError
            ``given`` is not a path.
        """
        return KeptFolder(Argument(given, declared).path().absolute(), is_temporary=False)

    @staticmethod
    def new(given: PathLike | None) -> KeptFolder:
        """Return a new or empty writable folder: ``given``, else a temporary one.

        Raises
        ------
        UserError
            ``given`` is not empty, not a folder, or cannot be created or written.
        """
        if given is None:
            return KeptFolder.temporary()
        path = Argument(given, Shared.FOLDER).path()
        hint = "choose another folder"
        try:
            if path.exists() and not path.is_dir():
                raise UserError.of(f"folder: {path} is a file", hint)
            path.mkdir(parents=True, exist_ok=True)
            if any(path.iterdir()):
                raise UserError.of(f"folder: {path} is not empty", f"{hint}, or remove this one")
        except (OSError, ValueError) as error:
            said = error.strerror if isinstance(error, OSError) else error
            raise UserError.of(f"folder: cannot create {path}: {said}", hint) from error
        if not os.access(path, os.W_OK | os.X_OK):
            raise UserError.of(f"folder: cannot write into {path}", hint)
        return KeptFolder(path.absolute(), is_temporary=False)
