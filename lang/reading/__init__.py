"""Parser of instructions: from a text to its meaning, by a language's phrases, or by chunks if they do not cover it."""
