"""Wrong arguments to the viewer's library raise instead of warning."""

import os

os.environ["RERUN_STRICT"] = "1"
