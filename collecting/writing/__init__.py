"""Stage 1: a person walks along the ground truth, and writes its instructions (paper, section "Data Collection")."""
