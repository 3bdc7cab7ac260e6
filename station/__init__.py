"""The operator's program: settings, pipeline, views, report and command line."""

import os

# The matrices here are small and the fits run side by side: a second thread inside each only gets in the way.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
