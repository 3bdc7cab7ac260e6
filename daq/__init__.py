"""A port in, a sealed session out: acquisition, sessions, replay and import."""
