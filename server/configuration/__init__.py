"""The server's settings: descriptions, defaults, and the sources of their values."""
