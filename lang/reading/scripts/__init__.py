"""Reading of a language in a second script: words compared by sound, and words and clauses of another language."""
