"""The workbench: one page on which the loop is closed by hand. The page shows; workers compute; results stay in sessions."""
