"""Shallow parsing of free texts: noun phrases, relations, sides and verbs are found, other words are skipped."""
