"""The soak test: players of a service whose parts are killed, cut off and restarted."""
