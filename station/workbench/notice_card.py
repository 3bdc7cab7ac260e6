"""A message that stays over the pictures until it is closed."""

from collections.abc import Callable

from station.workbench import widgets


class NoticeCard:
    """The card of a message; hidden while there is none."""

    def __init__(self, close: Callable[[], None]) -> None:
        self._close = close

    def build(self) -> None:
        """Make the card, hidden."""
        self._card = widgets.card("tight notice")
        with self._card, widgets.line():
            self._label = widgets.label("", "grow wrap")
            widgets.button("Close", self._close, "Close the message")
        self.show("")

    def show(self, text: str) -> None:
        """Show a message; "" hides the card."""
        self._label.text = text
        self._card.set_visibility(bool(text))
