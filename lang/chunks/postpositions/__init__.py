"""Readers of chunks in languages whose words that relate things stand behind them, such as Hindi."""
