"""Training: demonstrations, batches, recipes, imitation, rollouts, model cards; packages for agents of another kind."""
