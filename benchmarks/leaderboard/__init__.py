"""The leaderboard: coverage of intervals, power of tests, and time and size of large standings."""
