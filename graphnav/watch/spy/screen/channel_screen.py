"""The screen of one channel: fields, picture, plots."""

from __future__ import annotations

from typing import ClassVar

from rich.text import Text
from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Footer, Static

from graphnav import Message
from graphnav.arrays import Bytes
from graphnav.core.errors import CatalogError, DrawingError, shown_name
from graphnav.core.pictures import drawing
from graphnav.watch.feed import Received
from graphnav.watch.spy.screen.field_tree import FieldTree
from graphnav.watch.spy.screen.keys_screen import is_shown
from graphnav.watch.spy.screen.picture_view import PictureView
from graphnav.watch.spy.screen.plot_view import MAX_CURVES, PlotView
from graphnav.watch.spy.screen.reason_line import ReasonLine
from graphnav.watch.spy.screen.session import Session
from graphnav.watch.spy.series import Path, Series, measures_of, path_text
from graphnav.watch.spy.silence_reasons import losses
from graphnav.watch.spy.traffic_report import size_of

_PICTURE_S = 0.2
_TEXT_EVERY = 2
"""Fields are updated with every second picture, plots with every third one."""
_PLOT_EVERY = 3
_FEW_CURVES = 3
_VIEWS = ("picture", "plot", "both")
_ROWS_FOR_BOTH = 34


class ChannelScreen(Screen[None]):
    """The live view of one channel."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,backspace", "leave", "back", key_display="Esc", tooltip="back to all channels"),
        Binding("enter", "expand", "expand", tooltip="expand or collapse the field at the cursor"),
        Binding("p", "plot", "plot", tooltip="plot the number at the cursor, or remove it"),
        Binding("v", "view", "view", tooltip="picture, plot or both"),
    ]

    def __init__(self, name: str, session: Session) -> None:
        super().__init__()
        self._session = session
        self.channel_name = name
        self.picture: Bytes | None = None
        """The displayed picture."""
        self._series = Series()
        self._plotted: list[Path] = []
        self._has_chosen = False
        self._view = ""
        self._sample: Received | None = None
        self._shown: Received | None = None
        self._drawn_version: object = None
        self._turn = 0

    def compose(self) -> ComposeResult:
        """Lay out the screen."""
        yield Static(id="heading", markup=False)
        yield Static(id="channel", markup=False)
        yield ReasonLine()
        with Horizontal(id="body"):
            yield FieldTree(id="fields")
            with Vertical(id="views"):
                yield PictureView(self._session.new_painter(), id="picture")
                yield PlotView(id="plot", markup=False)
        yield Footer()

    def on_mount(self) -> None:
        """Start refreshing."""
        self.query_one("#picture").display = False
        self.set_focus(self.query_one(FieldTree))
        self.set_interval(_PICTURE_S, self.show)
        self._redraw()

    def on_resize(self) -> None:
        """Redraw in the new size."""
        self._redraw()

    def show(self, *, at_once: bool = False) -> None:
        """Update the screen, unless the view is frozen or hidden; ``at_once`` redraws everything."""
        if not is_shown(self):
            return
        self._turn += 1
        if at_once or self._turn % _TEXT_EVERY == 1:
            self.query_one("#heading", Static).update(self._session.heading(), layout=False)
        if self._session.is_frozen and not at_once:
            return
        if not self._session.is_frozen or self._sample is None:
            self._sample = self._session.watch.newest(self.channel_name)
        sample = self._sample
        if at_once or self._turn % _TEXT_EVERY == 1:
            self._show_texts(sample)
        if sample is None:
            return
        version, view = self._session.watch.version, self.query_one(PictureView)
        is_below_keys = view.is_raw and not self.is_active  # it would be painted over them
        if (at_once or version != self._drawn_version or view.wants_picture) and not is_below_keys:
            self._drawn_version = version
            self._show_picture(sample)
        self._collect(sample)
        if at_once or self._turn % _PLOT_EVERY == 1:
            self._show_plot()

    def _redraw(self) -> None:
        """Redraw everything after the layout."""
        self.call_after_refresh(self.show, at_once=True)

    def _show_texts(self, sample: Received | None) -> None:
        watch = self._session.watch
        channel = watch.channel(self.channel_name)
        parts = [shown_name(self.channel_name)]
        if channel is not None:
            parts.append(shown_name(channel.type_name or "unknown type"))
            parts += [f"{channel.count} messages", size_of(channel.last_bytes)] if channel.count else []
            parts += [losses(channel)] if losses(channel) else []
        self.query_one("#channel", Static).update(Text("  ".join(parts), "bold"), layout=False)
        self.query_one(ReasonLine).say(watch.why_empty(self.channel_name))
        values = None if sample is None else self._session.moment.values(sample.data)
        if values is not None and sample is not self._shown:
            self._shown = sample
            if not self._has_chosen:
                self._has_chosen = True
                self._plotted = measures_of(values)[:_FEW_CURVES]
            self.query_one(FieldTree).show(values, self._plotted)

    def _show_picture(self, sample: Received) -> None:
        """Draw the newest message; the view is hidden if its type has no picture."""
        view = self.query_one(PictureView)
        try:
            with drawing():
                message = self._session.moment.message(sample.data)
            if message is None:
                return
            self.picture = self._picture_of(message, view)
        except (DrawingError, CatalogError) as error:
            self.picture = None
            view.say(shown_name(f"cannot be drawn: {error}"))
            self._lay_out(has_picture=True)
            return
        self._lay_out(has_picture=self.picture is not None)
        if self.picture is not None:
            view.show(self.picture)

    def _picture_of(self, message: Message, view: PictureView) -> Bytes | None:
        rows, cols = view.box_px
        context = self._session.moment.context(rows, cols, with_legend=view.has_small_pixels)
        return self._session.pictures.draw(message, context)

    def _lay_out(self, *, has_picture: bool) -> None:
        """Show picture and plot, depending on availability and space."""
        picture, plot = self.query_one("#picture"), self.query_one("#plot")
        shows_picture = has_picture and self._chosen_view != "plot"
        shows_plot = not has_picture or self._chosen_view != "picture"
        if picture.display != shows_picture or plot.display != shows_plot:
            picture.display, plot.display = shows_picture, shows_plot
            self._redraw()

    @property
    def _chosen_view(self) -> str:
        """The view selected by v, else a default for the available space."""
        is_tall = self.size.height >= _ROWS_FOR_BOTH
        return self._view or ("both" if is_tall and self._plotted else "picture")

    def _collect(self, sample: Received) -> None:
        """Collect the numbers of all messages since the last update; of large messages only the newest is kept."""
        if sample.at_s < self._series.newest_s:
            self._series.clear()
        moment = self._session.moment
        samples = self._session.watch.recent(self.channel_name, self._series.newest_s)
        if not samples and sample.at_s > self._series.newest_s:
            samples = [sample]
        self._series.add((one, moment.values(one.data)) for one in samples)

    def _show_plot(self) -> None:
        plot = self.query_one(PlotView)
        if not plot.display:
            return
        if not self._plotted:
            plot.say("no field is plotted: p plots the number at the cursor")
            return
        curves = {path_text(path): self._series.points(path) for path in self._plotted}
        plot.show(curves, self._session.watch.origin_s, with_colour=self._session.has_colour)

    def action_leave(self) -> None:
        """Go back to all channels."""
        self.dismiss()

    def action_expand(self) -> None:
        """Expand or collapse the field at the cursor."""
        self.query_one(FieldTree).toggle()

    @on(FieldTree.Chosen)
    def _expand(self) -> None:
        self.action_expand()

    def action_plot(self) -> None:
        """Toggle the plot of the number at the cursor."""
        tree = self.query_one(FieldTree)
        field = tree.chosen
        if field is None or not field.is_number:
            self.notify("this field is not a number: expand it, or select another one", severity="warning")
            return
        self._has_chosen = True
        if field.path in self._plotted:
            self._plotted.remove(field.path)
        elif len(self._plotted) < MAX_CURVES:
            self._plotted.append(field.path)
        else:
            self.notify(
                f"{MAX_CURVES} fields are already plotted: press p on one of them to remove it", severity="warning"
            )
        self._shown = None
        self.show(at_once=True)

    def action_view(self) -> None:
        """Show the picture, the plot, or both."""
        self._view = _VIEWS[(_VIEWS.index(self._chosen_view) + 1) % len(_VIEWS)]
        self.show(at_once=True)
