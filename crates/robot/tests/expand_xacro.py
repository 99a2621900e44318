"""Python's xacro for xacro.rs: `list ROOT` names files and the packages below ROOT, `expand ROOT FILE` writes one out.

Packages are the folders of two levels below ROOT, by their names and what they are called in their files.
"""
import os
import sys
import types

import xacro


def packages(root):
    found = {}
    for first in sorted(os.listdir(root)):
        for second in ["."] + sorted(os.listdir(os.path.join(root, first)) if os.path.isdir(os.path.join(root, first)) else []):
            folder = os.path.normpath(os.path.join(root, first, second))
            if os.path.isdir(folder):
                name = os.path.basename(folder)
                # Copies of packages are often called by their robot.
                for alias in [name, name.removesuffix("_description"), name + "_support"]:
                    found.setdefault(alias, folder)
    return found


root = sys.argv[2]
known = packages(root)
# Where ROS is not installed, xacro asks these for the folder of a package.
index = types.ModuleType("ament_index_python.packages")
index.get_package_share_directory = lambda name: known[name]
sys.modules["ament_index_python"] = types.ModuleType("ament_index_python")
sys.modules["ament_index_python.packages"] = index

if sys.argv[1] == "list":
    for name, folder in known.items():
        print(f"package\t{name}\t{folder}")
    for folder, _, names in sorted(os.walk(root)):
        for name in sorted(names):
            if name.endswith(".xacro"):
                print(f"file\t{os.path.join(folder, name)}\t")
else:
    print(xacro.process_file(sys.argv[3]).toxml())
