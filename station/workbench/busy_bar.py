"""What runs for a session: its title, how far it is, how long it has taken, and a way to stop it."""

import time
from collections.abc import Callable

from nicegui import ui

from station.workbench import widgets
from station.workbench.session_state import SessionState

SLOW_S = 0.4
"""Seconds after which a step that was thought to be short is shown to run."""


class BusyBar:
    """A line over the page, seen only while something runs that takes a while."""

    def build(self, cancel: Callable[[], object]) -> None:
        """Lay out the line; `cancel` stops what runs."""
        self._line = ui.element("section").classes("card tight busybar").props("role=status aria-live=polite")
        with self._line, widgets.line():
            widgets.spinner()
            self._label = widgets.label("", "grow")
            self._bar = (
                ui.linear_progress(0.0, show_value=False).props("instant-feedback rounded").classes("share")
            )
            widgets.button("Cancel", cancel)
        self._line.set_visibility(False)

    def show(self, session: SessionState) -> bool:
        """Show what runs for a session; return whether it is shown."""
        running = session.running
        if running is None:
            self._line.set_visibility(False)
            return False
        seconds = time.monotonic() - running.since
        slow = running.long or seconds > SLOW_S
        self._line.set_visibility(slow)
        if slow:  # each change is a message to the browser, which then lays out the page
            self._label.text = (
                f"{running.title}: {session.progress or 'waiting for a free worker'} ({seconds:.0f} s)"
            )
            done = session.share_done
            self._bar.set_visibility(done is not None)
            self._bar.value = round(done or 0.0, 2)
        return slow
