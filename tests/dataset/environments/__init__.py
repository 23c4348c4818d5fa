"""Tests of `arramon_dataset.environments`."""
