"""`python -m server` is `arramon-server`."""

import sys

from server.cli import main

sys.exit(main())
