"""Results of runs: reports, signed receipts, the host's signing key, and rescoring."""
