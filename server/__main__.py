"""Entry point of `python -m server`, the same as `arramon-server`."""

import sys

from server.cli import main

sys.exit(main())
