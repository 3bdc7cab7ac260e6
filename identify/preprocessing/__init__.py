"""From a raw record to a prepared decay: noise, release, lag, motion."""
