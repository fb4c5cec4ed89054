"""A robot that lives in a building: it explores, remembers every look, and finds itself again."""

from tutorial_lib.agents.lifelong.agent import LifelongAgent, LifelongSettings

__all__ = ["LifelongAgent", "LifelongSettings"]
