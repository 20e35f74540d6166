"""Import optional packages."""

from __future__ import annotations

from typing import Any

from graphnav.core.errors import UserError
from graphnav.core.machine.extras import install_command


def import_pandas(who: str) -> Any:
    """Return pandas, for ``who``.

    Raises
    ------
    UserError
        It is not installed.
    """
    try:
        import pandas  # noqa: ICN001 - an extra
    except ImportError as error:
        raise UserError.of(f"{who} needs pandas", install_command("pandas")) from error
    return pandas
