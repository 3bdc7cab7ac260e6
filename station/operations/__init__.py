"""What the operator can have done: capture, identify, compare, diagnose, refine."""
