"""The keys of a screen, shown over it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.screen import ModalScreen, Screen
from textual.widgets import Static


class KeysScreen(ModalScreen[None]):
    """Lists the keys that are active on a screen, as its bindings and those of the app declare them."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("question_mark,escape,enter,space", "dismiss", "close", key_display="?"),
    ]

    def __init__(self, screen: Screen[None]) -> None:
        super().__init__()
        self._lines = list(_lines(screen))

    def compose(self) -> ComposeResult:
        """Lay out the list."""
        width = max(len(keys) for keys, _ in self._lines)
        text = Text("\n").join(Text.assemble((keys.rjust(width), "bold"), "  ", what) for keys, what in self._lines)
        yield Static(Text("keys\n\n", "bold").append(text).append("\n\n? closes", "dim"), id="keys", markup=False)

    def on_click(self) -> None:
        """Close."""
        self.dismiss()


def is_shown(screen: Screen[None]) -> bool:
    """Whether a screen is the one that is seen, also if its keys are listed over it."""
    stack = screen.app.screen_stack
    return screen in stack[-1:] or (screen in stack[-2:] and isinstance(stack[-1], KeysScreen))


def _lines(screen: Screen[None]) -> Iterator[tuple[str, str]]:
    """Yield the keys of each action of a screen and its meaning, the screen's own first."""
    for node, bindings in ((screen, screen.BINDINGS), (screen.app, screen.app.BINDINGS)):
        for binding in bindings:
            assert isinstance(binding, Binding)
            action, _, _ = binding.action.partition("(")
            if node.check_action(action, ()):
                keys = [screen.app.get_key_display(one) for one in binding.make_bindings([binding])]
                yield binding.key_display or " ".join(dict.fromkeys(keys)), binding.tooltip or binding.description
