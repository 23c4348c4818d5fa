"""The command `python -m website`: builds the documentation's site, and checks it."""

import argparse
import sys
import time
from pathlib import Path

from website.build import BuildError, build
from website.checks import problems


def main() -> int:
    """Build the site and return the exit status: 0 if it is without fault, else 1."""
    parser = argparse.ArgumentParser(prog="python -m website", description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("build/site"), help="the site's folder")
    given = parser.parse_args()
    began = time.monotonic()
    try:
        build(given.output)
    except BuildError as error:
        sys.stderr.write(f"{error}\n")
        return 1
    found = problems(given.output)
    sys.stderr.write("".join(f"{problem}\n" for problem in found))
    if found:
        return 1
    size = sum(path.stat().st_size for path in given.output.rglob("*") if path.is_file())
    pages = len(list(given.output.rglob("*.html")))
    sys.stdout.write(
        f"{given.output}: {pages} pages, {size / 1e6:.1f} MB, in {time.monotonic() - began:.0f} seconds; "
        f"to read them: python -m http.server --bind 127.0.0.1 --directory {given.output}\n"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
