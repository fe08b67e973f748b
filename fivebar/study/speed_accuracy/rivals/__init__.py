"""The same motions in other simulators: packages that fivebar itself does not need."""
