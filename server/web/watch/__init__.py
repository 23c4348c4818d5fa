"""Pages and files on which recorded episodes are watched, step by step, also while they are played."""
