"""Free texts read in chunks: their things, the words that relate them, sides and verbs, whatever is between them."""
