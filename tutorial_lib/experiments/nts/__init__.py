"""Neural Topological SLAM (Chaplot et al. 2020): one module for each table and figure."""
