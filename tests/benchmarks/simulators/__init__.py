"""The five-bar in other simulators, for the charts of speed against accuracy."""
