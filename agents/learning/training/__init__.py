"""Training: demonstrations, batches, recipes, imitation, rollouts, model cards; and the agents that learn otherwise."""
