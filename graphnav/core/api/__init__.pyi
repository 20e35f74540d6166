# What the rest of graphnav takes of this folder, each imported on first use.

from .arguments import Argument, PathLike
from .blas_threads import one_blas_thread, one_thread
from .load import loaded, with_run_options
from .notices import tell
from .parameters import Shared, TapMode
from .result_folder import KeptFolder

__all__ = [
    "Argument",
    "KeptFolder",
    "PathLike",
    "Shared",
    "TapMode",
    "loaded",
    "one_blas_thread",
    "one_thread",
    "tell",
    "with_run_options",
]
