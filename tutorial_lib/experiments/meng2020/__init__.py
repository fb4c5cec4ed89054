"""Tables and figures of Meng 2020."""
