"""Runs played step by step, synchronously or asynchronously: `Run`, `AsyncRun` and their episodes."""
