"""What the tests of the live page share: the page opened, a hand on it, and what is read from it."""

from .browsing import settle

LENGTHS = ("l11", "l12", "l21", "l22", "d")
STILL = dict(reduced_motion="reduce")  # the robot does not move by itself at the beginning
PHONE = dict(width=390, height=844, has_touch=True, is_mobile=True)


def pose_of(page):
    return page.evaluate("({xi: pose.xi, q: pose.q, modes, assembly: pose.assembly, p})")


def on_screen(page, point):
    """Where a point of the plane is on the screen."""
    box = page.locator("#plane").bounding_box()
    x, y = page.evaluate("point => task.at(point)", list(point))
    return box["x"] + x, box["y"] + y


def drag(page, start, *points):
    page.mouse.move(*on_screen(page, start))
    page.mouse.down()
    for point in points:
        page.mouse.move(*on_screen(page, point), steps=4)
    page.mouse.up()
    settle(page)
