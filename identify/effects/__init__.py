"""The library of effects: one physical cause of force, or one fault of a sensor, an entry."""
