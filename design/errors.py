"""What a study file can be refused for, and what a design can lack."""


class StudyError(ValueError):
    """A study file that cannot be used; the message has one line a problem."""


class UnknownResponseError(ValueError):
    """A response that a design does not have, with the reason: a solver that stopped, a mode that is not there."""
