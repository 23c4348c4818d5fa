"""Entry point of `python -m arramon_client`, the same as the command `arramon-client`."""

import sys

from arramon_client.cli import main

sys.exit(main(sys.argv[1:]))
