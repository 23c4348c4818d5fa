"""The embedded server on this machine, and its first episodes."""
