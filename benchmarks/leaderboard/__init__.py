"""The leaderboard: what intervals and tests hold, and time and size of large standings."""
