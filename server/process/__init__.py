"""A server process: assembly, start and drain, workers, readiness, metrics, logs and TLS."""
