"""Table of what is owed."""
