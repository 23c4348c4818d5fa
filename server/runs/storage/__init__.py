"""Storage: the journal of runs, claims and steps, the registry of workers, and the database migrations."""
