"""One file for each reproduced table or figure, and the demo."""
