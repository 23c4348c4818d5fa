"""Programs that play an episode through a framework's own client; each runs where that framework is installed.

Arguments: address of the server, language, episode id, actions as digits, and the file for the result as JSON.
"""
