"""What experiments share: options, reports, statistics, stored results and agents."""
