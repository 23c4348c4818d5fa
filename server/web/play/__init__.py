"""Play in the browser: a WebSocket for each player, joined to the same engine as the streams of agents."""
