"""What all tests share."""

from hypothesis import settings

# no test may fail because a machine is slow
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")
