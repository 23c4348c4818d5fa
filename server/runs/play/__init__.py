"""The engine that plays episodes, and the parts of it."""
