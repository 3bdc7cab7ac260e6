"""The operator's program: settings, pipeline, views, report and command line."""
