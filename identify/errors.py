"""The one error of this package: what was recorded does not allow the answer."""


class NotIdentifiable(ValueError):
    """The record holds too little to identify; the message says what, where and what to do (exit code 8)."""
