#pragma once

#include <tenon/plants/signals/elevation_map.h>

namespace tenon::test {

/// A map around the origin, of ground whose height is a function of x and y.
template <class Height>
ElevationMap MapOf(Height&& height, double cell = 0.03) {
  constexpr int n = ElevationMap::kSize;
  ElevationMap map;
  map.cell = cell;
  map.first_W.setConstant(-cell * n / 2);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      map.height[static_cast<std::size_t>(i + n * j)] =
          height(map.first_W[0] + cell * i, map.first_W[1] + cell * j);
  return map;
}

}  // namespace tenon::test
