"""The leaderboard's data: which runs are published, how they stand, and what the paper reports."""
