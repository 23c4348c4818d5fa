"""A server process: assembly, start, drain, workers, readiness, metrics, logs and TLS."""
