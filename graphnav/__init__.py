"""Visual navigation as a dataflow graph: plugin stages, LCM channels, a simulated robot to close the loop.

The public names are in ``__init__.pyi``. Each is imported on first use, so that ``graphnav --help`` loads no numpy;
and so that what numpy computes with can be pinned before it is loaded.
"""

from graphnav.core.machine.pins import pin

__version__ = "0.8.2"

pin()


def __getattr__(name: str) -> object:
    """Import a public name; the first use reads which there are."""
    import lazy_loader  # noqa: PLC0415 - it reads the list with ast, in as long as all else of --help

    attribute_of, listed, names = lazy_loader.attach_stub(__name__, __file__)
    globals().update(__getattr__=attribute_of, __dir__=listed, __all__=["__version__", *names])
    return globals()[name] if name == "__all__" else attribute_of(name)


def __dir__() -> list[str]:
    """Return the public names."""
    return __getattr__("__all__")  # type: ignore[return-value]
