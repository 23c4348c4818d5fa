"""Pages of collections for workers and hosts, under `/LANGUAGE/collect/NAME/`."""
