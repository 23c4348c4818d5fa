"""Accounts: participants, their tokens, limits and usage, and the caller of a request."""
