"""The report of a session: one page to attach to a test report."""
