"""Free instructions by writers who see an episode but not the grammar: their sheets and their texts."""
