#include <tenon/systems/geometry.h>

TENON_DEFINE_SIGNAL(tenon::Geometry);
