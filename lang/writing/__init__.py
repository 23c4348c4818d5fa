"""Writer of instructions: renders a meaning as a text, by a language's grammar and phrases, in one speaker's voice."""
