"""Episodes: definition, files and splits."""
