"""The lab's runtime without ROS: what `fivebar run` puts under a script. Nothing here is importable
by the lab's names (`lab_amoro`, `rclpy`) outside of its child process.
"""
