# What the rest of graphnav takes of this folder, each imported on first use.

from .arguments import (
    PathLike,
    check_choice,
    check_integer,
    check_text,
    overrides_of,
    path_of,
    paths_of,
    texts_of,
    wrong_type,
    yaml_value,
)
from .blas_threads import one_thread
from .load import add_plugins, loaded, with_run_options
from .notices import tell
from .parameters import Shared, TapMode
from .result_folder import KeptFolder

__all__ = [
    "KeptFolder",
    "PathLike",
    "Shared",
    "TapMode",
    "add_plugins",
    "check_choice",
    "check_integer",
    "check_text",
    "loaded",
    "one_thread",
    "overrides_of",
    "path_of",
    "paths_of",
    "tell",
    "texts_of",
    "with_run_options",
    "wrong_type",
    "yaml_value",
]
