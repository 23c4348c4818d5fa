"""Machine readers that play as people do, through the play page's WebSocket."""
