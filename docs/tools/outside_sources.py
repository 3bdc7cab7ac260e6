"""What a built page or style sheet would load from other hosts: scripts, styles, fonts, pictures, frames."""

import re
from html.parser import HTMLParser

LOADING = {"script": "src", "img": "src", "iframe": "src", "source": "src", "video": "src", "embed": "src"}
LINKS = {
    "stylesheet",
    "preload",
    "preconnect",
    "dns-prefetch",
    "prefetch",
    "modulepreload",
    "icon",
    "manifest",
}


def outside_sources(text: str, ending: str = ".html") -> list[str]:
    """Return the addresses on other hosts from which a page or style sheet would load something."""
    if ending == ".css":
        found = re.findall(r"""(?:url\(|@import)\s*["']?((?:https?:)?//[^"')\s]+)""", text)
        return [str(address) for address in found]
    reader = _Sources()
    reader.feed(text)
    return reader.outside


class _Sources(HTMLParser):
    """Collects what a page loads from other hosts; a link that a reader may follow is not loaded."""

    def __init__(self) -> None:
        super().__init__()
        self.outside: list[str] = []
        self._in_style = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._in_style = tag == "style"
        values = dict(attrs)
        address = values.get(LOADING.get(tag, "")) or ""
        if tag == "link" and LINKS & set((values.get("rel") or "").split()):
            address = values.get("href") or ""
        if re.match(r"(https?:)?//", address):
            self.outside.append(address)

    def handle_data(self, data: str) -> None:
        if self._in_style:
            self.outside.extend(outside_sources(data, ".css"))
            self._in_style = False
