"""Instructions written freely by writers who see an episode but not the grammar: their sheets and texts."""
