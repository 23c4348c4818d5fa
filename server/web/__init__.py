"""The web server in each server process: the leaderboard's pages, health probes and metrics."""
