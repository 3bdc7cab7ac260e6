"""`python -m mocks`: start the bench's double."""

import sys

from mocks.cli import main

sys.exit(main())
