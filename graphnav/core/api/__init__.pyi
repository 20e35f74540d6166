# What the rest of graphnav takes of this folder, each imported on first use.

from .arguments import Argument, PathLike
from .blas_threads import one_thread
from .load import loaded
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
    "one_thread",
    "tell",
]
