"""Export and import of all runs, accounts and leaderboard entries, to move them to another host."""
