"""Import of the official release: its file format, and reconstruction of the missing city and objects."""
