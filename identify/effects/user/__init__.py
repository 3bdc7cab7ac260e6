"""A user's own effects: formulas, read and checked."""

from identify.effects.user.definition import own_effect, parse_effect

__all__ = ["own_effect", "parse_effect"]
