"""Episodes: their definition, their files, and splits."""
