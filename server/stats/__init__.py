"""What a data set is like: lengths, words, diversity and linguistic properties, as the paper reports them."""
