"""Agents: the tables of docs/results.md and docs/transfer.md, and pictures of played ways."""
