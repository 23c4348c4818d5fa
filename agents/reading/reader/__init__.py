"""The learned reader: a small network that parses instructions of all its languages into steps."""
