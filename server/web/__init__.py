"""The web: the leaderboard's pages, probes and metrics, from the same process as the server."""
