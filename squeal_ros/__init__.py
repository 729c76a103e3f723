"""The ROS 2 side: node, replay, drive player and command line around `squeal_core`."""
