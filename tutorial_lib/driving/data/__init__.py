"""What networks learn from: trajectories, pairs of places, and how rollouts end."""
