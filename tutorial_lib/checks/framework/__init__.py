"""What a check is, how students' functions are called, and how answers are compared."""
