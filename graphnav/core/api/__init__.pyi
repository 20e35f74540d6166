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
from .parameters import FOLDER, GRAPH, LIVE, LIVE_URL, LOADED, OF_RUN, PLUGINS, SEED, SET, TAP, TRUST, UNTIL_S, TapMode
from .result_folder import KeptFolder, named_folder, new_folder, temporary_folder

__all__ = [
    "FOLDER",
    "GRAPH",
    "LIVE",
    "LIVE_URL",
    "LOADED",
    "OF_RUN",
    "PLUGINS",
    "SEED",
    "SET",
    "TAP",
    "TRUST",
    "UNTIL_S",
    "KeptFolder",
    "PathLike",
    "TapMode",
    "add_plugins",
    "check_choice",
    "check_integer",
    "check_text",
    "loaded",
    "named_folder",
    "new_folder",
    "one_thread",
    "overrides_of",
    "path_of",
    "paths_of",
    "tell",
    "temporary_folder",
    "texts_of",
    "with_run_options",
    "wrong_type",
    "yaml_value",
]
