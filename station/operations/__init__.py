"""The operations: capture, identify, compare, diagnose, refine."""
