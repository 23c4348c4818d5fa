"""Statistics of a data set: lengths, words, diversity and linguistic properties, as reported in the paper."""
