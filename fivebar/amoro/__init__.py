"""The AMORO lab's own ten functions, on plain floats, with its signatures and return shapes, for
any robot.
"""

from .models import models as models
