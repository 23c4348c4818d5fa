"""The documentation's site: `python -m website` builds it from `docs/` and from the code; `scripts/docs` runs it."""
