"""Training that all agents share: the loop, its checkpoints, demonstrations, batches, rollouts, model cards."""
