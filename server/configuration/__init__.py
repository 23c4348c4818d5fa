"""The server's settings: their definitions, defaults and sources."""
