"""Runs: storage, play, accounts, results and transfer, and the service on top of them."""
