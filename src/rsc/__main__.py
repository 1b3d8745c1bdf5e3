"""`python -m rsc` is the command line."""

import sys

from rsc.cli import main

sys.exit(main())
