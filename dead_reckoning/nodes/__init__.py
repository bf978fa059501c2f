"""Thin ROS 2 nodes around a chain: parameters, messages, topics, services, diagnostics."""
