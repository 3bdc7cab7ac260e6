"""`python -m mocks`: start the bench's double."""

import os
import sys

sys.path[:] = [
    place for place in sys.path if os.path.isabs(place)
]  # an editable installation adds one that is not

from mocks.cli import main  # noqa: E402

sys.exit(main())
