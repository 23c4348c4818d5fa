"""Statistics of a data set: lengths, words, diversity and linguistic properties, as in the paper."""
