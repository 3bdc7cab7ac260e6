"""The library of effects: one physical cause of force, or one fault of a sensor, an entry."""

import identify.compilation  # noqa: F401  numba is imported there, blind to the working folder, before any effect does
