"""What effects are called on the page."""

from identify.formatting import plain_name as plain

__all__ = ["plain", "title"]


def title(name: str) -> str:
    """Return an effect's name for people as the beginning of a line."""
    words = plain(name)
    return f"{words[:1].upper()}{words[1:]}"
