"""Read and write ROS 2 bags, in the types of graphnav."""

from graphnav.core.record.bags.bag import BAG_SUFFIXES, Bag, is_bag
from graphnav.core.record.bags.bag_writer import BagWriter

__all__ = ["BAG_SUFFIXES", "Bag", "BagWriter", "is_bag"]
