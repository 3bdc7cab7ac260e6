"""The workbench: one page to compare, diagnose and refine. The page shows, workers compute, sessions keep."""
