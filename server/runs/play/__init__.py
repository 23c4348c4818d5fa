"""The engine that plays episodes, and its components."""
