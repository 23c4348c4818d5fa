"""`arramon-server` with batches of one episode, as each episode takes a second or more to generate."""

import sys

from arramon_dataset.generation import batches
from arramon_server import cli


def main(arguments: list[str]) -> int:
    batches.BATCH_SIZE = 1
    return cli.main(arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
