"""What the RMP policies of notebook 02 return."""

PARTS = "return two things, the accelerations and the metrics"
