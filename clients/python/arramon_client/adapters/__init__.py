"""Adapters to evaluation and training frameworks; each is imported by itself, and needs an extra of its own."""
