"""The bench's double: a testbed with its own physics and a board that speaks the real protocol."""
