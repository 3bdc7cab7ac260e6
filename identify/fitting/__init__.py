"""Fitting a model to releases, and the noise floor that it is measured against."""
