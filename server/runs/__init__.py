"""Runs: everything that must survive a restart."""
