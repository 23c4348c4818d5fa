"""What hosts see of a collection: progress, texts in review, workers, money."""
