"""Curves: frequency and loss of one isolated mode against amplitude, and the laws that they show."""
