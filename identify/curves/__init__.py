"""Curves: frequency and loss against amplitude, of one isolated mode, and what they tell of the laws behind them."""
