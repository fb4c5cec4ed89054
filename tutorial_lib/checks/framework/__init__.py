"""What a check is, and how answers are compared."""
