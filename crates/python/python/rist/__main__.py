"""`python -m rist` is the command `rist`."""

import sys

from ._program import main

sys.exit(main())
