"""What an episode is, its files, and where episodes come from."""
