"""Export and import of all runs, accounts and leaderboard entries, to move a server to another host."""
