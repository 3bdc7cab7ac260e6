"""Fitting a model to releases, and the noise floor to which its residual is compared."""
