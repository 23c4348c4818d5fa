"""The leaderboard: published runs, their standings, and the results of the paper."""
