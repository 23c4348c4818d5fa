"""Reading: from a text to its meaning, by a language's written phrases, or in chunks where they do not cover it."""
