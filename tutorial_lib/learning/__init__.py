"""Learning: labels, networks, their training and their weights; the only place that has torch."""
