"""A small statistical reader that shares nothing with the grammar: how well a text fits a route, word by word."""
