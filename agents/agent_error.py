"""The error of every agent: by name, from a file, or trained."""


class AgentError(ValueError):
    """No agent of that name, or a file, class or model that is none."""
