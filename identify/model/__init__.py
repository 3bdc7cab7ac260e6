"""A model as a sum of effects, and its simulation."""
