#!/bin/sh
# Generates the types of a ros2.idl for Fast DDS. usage: fast_dds_types.sh FASTDDSGEN IDL DIRECTORY
#
# The generator adds dds_ and the underscores itself, as for ROS 2's own files. It refuses a member that is named as a type in its
# module; on the wire, members have no names.
set -e
mkdir -p "$3"
cd "$3"
sed -e 's/ { module dds_ {$/ {/; s/^}; }; };/}; };/; s/msg::dds_::/msg::/g; s/@final //' \
  -e 's/\b\([A-Z][A-Za-z0-9]*\)_\b/\1/g; s/struct String /struct _String /' \
  -e 's/\b\(Pose pose\|Twist twist\|Wrench wrench\|Transform transform\);/\1_value;/' "$2" > ros2.idl
"$1" -typeros2 -replace ros2.idl > log 2>&1 || { cat log; exit 1; }
