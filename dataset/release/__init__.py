"""Import of the official release: its file format, and reconstruction of the city and objects missing from its files."""
