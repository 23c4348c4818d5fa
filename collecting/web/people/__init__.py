"""Pages of workers: joining, their own page, and what comes before the first task."""
