"""Writing: from a meaning to a text, by a language's grammar and phrases, in one speaker's voice."""
