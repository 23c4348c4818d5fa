"""Pages on which workers follow texts."""
