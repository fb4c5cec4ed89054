"""One run on film."""
