"""Image-goal navigation in places never seen: ghost nodes (Chaplot et al. 2020) and frontiers."""
