"""Scoring of recorded trajectories: pure functions, independent of the simulator, gRPC and storage."""
