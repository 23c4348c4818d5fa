"""The learned reader: a small sequence-to-sequence network that parses instructions of all languages to meanings."""
