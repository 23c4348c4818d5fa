"""The page on which workers write."""
